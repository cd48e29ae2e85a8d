// Kinematics of the open-hardware arms (WoodenHaptics, Polhem), whose geometry is read from a preset file. The
// functions have no state. Frame H is the frame of the arm's base: x towards the user, y to the right, z up. The bodies
// A, B and C are the parts of the arm that the motors drive: A rotates about z, and the angles of B and C are measured
// from the vertical.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <string>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// Geometry and limits of an arm in SI units. All values must come from one preset file. Published sources use
/// different signs and constants, so values from different sources must not be combined.
struct Arm {
  std::string name;
  enum class Linkage { kSerial, kFiveBar } linkage = Linkage::kSerial;
  // m, two diameters for each of the bodies A, B and C (the parts of the arm that the motors drive). capstan: diameter
  // of the capstan on the body's motor; body: diameter of the body itself.
  dvec3 capstan{0}, body{0};
  double La = 0, Lb = 0, Lc = 0;   // m, lengths of the links, if the linkage is serial
  std::array<double, 6> L{};       // m, lengths of the links, if the linkage is a five-bar linkage
  dvec3 origin{0};                 // m, origin of the workspace in the frame of the base
  dvec3 torque_constant{0};        // N·m/A, for each motor: torque per ampere
  std::array<double, 6> counts{};  // encoder counts per turn for A…F; 0 for D…F: the stylus has no encoders
  std::array<double, 6> sign{1, 1, 1, 1, 1, 1};  // +1; -1 if the angle of the joint decreases while its count increases
  std::array<std::int64_t, 6> home{};            // counts of the six encoders in the home position
  double current_limit = 3;                  // A, largest current of a motor; the firmware of the boards has no limit
  double force_limit = 5, stiffness = 1000;  // N, largest force; N/m, largest stiffness
  double continuous_force = 0;               // N, force that the motors can give permanently without overheating
  double vibration_band = 0;                 // Hz, largest vibration frequency that the arm can render
  double silence = 0;  // s, time without a write after which the watchdog sends zero force; 0: the default, 1.8 ms
  // rad/s, largest angular speed of a body A, B, C and of an axis of the stylus; a count that changes faster than this
  // is treated as an error of the encoder
  double joint_speed = 30;
  // Values for the gravity compensation of the bodies B and C: masses, and distances of their centres of mass from
  // their joints.
  double mass_b = 0, mass_c = 0, center_b = 0, center_c = 0;  // kg, m

  bool has_stylus() const { return counts[3] > 0 && counts[4] > 0 && counts[5] > 0; }
  double ratio(int i) const { return capstan[i] / body[i]; }
  /// Returns the largest number of counts by which encoder i can change within dt seconds.
  std::int64_t reach(int i, double dt) const;
};

/// Reads the preset file assets/devices/NAME.json. Throws Error.
Arm read_arm(const std::filesystem::path& file);

using Counts = std::array<std::int64_t, 6>;

/// Returns the angles (rad) of the bodies A, B, C (the parts of the arm that the motors drive).
dvec3 body_angles(const Arm& arm, const Counts& counts);
/// Returns the angles (rad) of the stylus joints D, E, F. They are invalid if the stylus has no encoders.
dvec3 stylus_angles(const Arm& arm, const Counts& counts);
/// Returns the pose of the stylus tip in frame H of the arm's base. The orientation was not verified on hardware, and
/// published sources contradict each other.
Pose stylus_pose(const Arm& arm, const Counts& counts);
dvec3 stylus_position(const Arm& arm, const dvec3& theta);
/// Returns the Jacobian matrix of the position of the tip. Its columns are ∂p/∂A, ∂p/∂B, ∂p/∂C in m/rad.
glm::dmat3 jacobian(const Arm& arm, const dvec3& theta);
/// Returns the distance (m) that the tip moves if the encoders A, B and C all change by one count, in the home
/// position.
double position_step(const Arm& arm);
/// Returns the torques (N·m) on the bodies A, B, C that compensate the weight of the arm. They are zero if the preset
/// contains no masses.
dvec3 gravity_torque(const Arm& arm, const dvec3& theta);

struct Currents {
  dvec3 amperes{0};
  bool clipped = false;
};
/// Computes the motor currents for a force (N) in frame H of the device's base and the additional torques `holding`
/// (N·m) on the bodies. If a current exceeds its limit, all currents are reduced by the same factor, so that the force
/// keeps its direction.
Currents motor_currents(const Arm& arm, const dvec3& theta, const dvec3& f_S_H, const dvec3& holding);

}  // namespace typodont::haptics
