// Kinematics of the open-hardware arms (WoodenHaptics, Polhem), with geometry from a preset file. Pure functions.
// Frame H, the arm's base: x toward the user, y right, z up. Angles of the bodies: A about z; B and C absolute, from
// the vertical.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <string>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// Geometry and limits of an arm. SI units. All values must come from one preset file: published sources differ in
/// signs and constants, so their values must not be mixed.
struct Arm {
  std::string name;
  enum class Linkage { kSerial, kFiveBar } linkage = Linkage::kSerial;
  dvec3 capstan{0}, body{0};                     // m, diameters of capstans and bodies for A, B, C
  double La = 0, Lb = 0, Lc = 0;                 // m, serial linkage
  std::array<double, 6> L{};                     // m, five-bar linkage
  dvec3 origin{0};                               // m, origin of the workspace in the base
  dvec3 torque_constant{0};                      // N·m/A
  std::array<double, 6> counts{};                // counts per encoder turn, A…F; 0 for D…F: no stylus encoders
  std::array<double, 6> sign{1, 1, 1, 1, 1, 1};  // factor on the count, -1 if the preset calls motor and body "aligned"
  std::array<std::int64_t, 6> home{};            // counts of the six encoders in the home position
  double current_limit = 3;                      // A, limit for each motor; the firmware has no limit
  double force_limit = 5, stiffness = 1000, damping = 0;  // N, N/m, N·s/m
  double continuous_force = 0;                            // N, force that the motors can give continuously
  double vibration_band = 0;                              // Hz, limit of the vibration frequencies that the arm renders
  double silence = 0;                                     // s, timeout of the watchdog; 0: the default of 1.8 ms
  double joint_speed = 30;  // rad/s, limit of the bodies' speed; a faster motion counts as a sensor error
  // Gravity compensation of bodies B and C: masses, and distances of their centres from the joint.
  double mass_b = 0, mass_c = 0, center_b = 0, center_c = 0;  // kg, m

  bool has_stylus() const { return counts[3] > 0 && counts[4] > 0 && counts[5] > 0; }
  double ratio(int i) const { return capstan[i] / body[i]; }
  /// Largest number of counts by which encoder i can change in dt seconds.
  std::int64_t reach(int i, double dt) const;
};

/// Reads assets/devices/NAME.json. Throws Error.
Arm read_arm(const std::filesystem::path& file);

using Counts = std::array<std::int64_t, 6>;

/// Body angles A, B, C, rad.
dvec3 body_angles(const Arm& arm, const Counts& counts);
/// Angles of the stylus joints D, E, F, rad; invalid without stylus encoders.
dvec3 stylus_angles(const Arm& arm, const Counts& counts);
/// Pose of the stylus tip in H. The orientation is not verified on hardware, and published sources disagree.
Pose stylus_pose(const Arm& arm, const Counts& counts);
dvec3 stylus_position(const Arm& arm, const dvec3& theta);
/// Jacobian of the tip's position; its columns are ∂p/∂A, ∂p/∂B, ∂p/∂C.
glm::dmat3 jacobian(const Arm& arm, const dvec3& theta);
/// Motion of the tip, m, for one count of each of the three encoders together, in the home position.
double position_step(const Arm& arm);
/// Torques on the bodies, N·m, that compensate the arm's weight; zero if no masses are given.
dvec3 gravity_torque(const Arm& arm, const dvec3& theta);

struct Currents {
  dvec3 amperes{0};
  bool clipped = false;
};
/// Motor currents for a force in H, plus the torques `holding` (N·m) on the bodies. If a current exceeds its limit,
/// all currents are scaled down, so that the force keeps its direction.
Currents motor_currents(const Arm& arm, const dvec3& theta, const dvec3& f_S_H, const dvec3& holding);

}  // namespace typodont::haptics
