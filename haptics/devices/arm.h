// Kinematics of WoodenHaptics and Polhem arms, whose dimensions come from a preset file. Stateless. Base frame H: x to
// the user, y right, z up. Motors drive the bodies A (angle about z), B and C (angles from the vertical).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <string>

#include "engine/base/arm_geometry.h"

namespace typodont::haptics {

/// An arm's parameters in SI units, all from one preset, because published sources differ in signs and constants.
struct Arm {
  std::string name;
  enum class Linkage { kSerial, kFiveBar } linkage = Linkage::kSerial;
  // Diameters of the motors' capstans, and of the bodies A, B, C that they drive, m.
  dvec3 capstan{0}, body{0};
  // Links (used if the linkage is serial) and origin, from the preset or measured. The tip is at the wrist's centre
  // until the arm was measured.
  ArmGeometry geometry{.tip_S = {0, 0, 0}};
  std::array<double, 6> L{};                     // m, lengths of the links of a five-bar linkage
  dvec3 torque_constant{0};                      // N·m/A, for each motor: torque per ampere
  std::array<double, 6> counts{};                // counts per turn of encoders A to F; 0: no stylus encoders
  std::array<double, 6> sign{1, 1, 1, 1, 1, 1};  // -1: the angle decreases when the count increases
  std::array<std::int64_t, 6> home{};            // counts of the encoders A to F in the home position
  double current_limit = 3;                      // A, largest motor current; the firmware itself has no limit
  double force_limit = 5, stiffness = 1000;      // N, largest force; N/m, largest stiffness
  double continuous_force = 0;                   // N, force that the motors can give permanently without overheating
  double vibration_band = 0;                     // Hz, largest vibration frequency that the arm can render
  double silence = 0;  // s, time without a write after which the force becomes zero; 0: 1.8 ms
  // Largest speed of a joint, rad/s; faster changes of a count are encoder errors.
  double joint_speed = 30;
  // Mass of bodies B and C, and distance of their centres of mass from their joints, for gravity compensation.
  double mass_b = 0, mass_c = 0, center_b = 0, center_c = 0;  // kg, kg, m, m

  bool has_stylus() const { return counts[3] > 0 && counts[4] > 0 && counts[5] > 0; }
  double ratio(int i) const { return capstan[i] / body[i]; }
  /// Largest plausible change of encoder i in dt seconds, counts.
  std::int64_t reach(int i, double dt) const;
};

/// Reads the preset file assets/devices/NAME.json. Throws Error.
Arm read_arm(const std::filesystem::path& file);

using Counts = std::array<std::int64_t, 6>;

/// Uses the measured geometry of an arm from now on. Throws Error if the arm is not serial or has no stylus encoders.
void use_measured(Arm& arm, const ArmGeometry& geometry);

/// Angles of the bodies A, B, C as the encoders state them, rad.
dvec3 body_angles(const Arm& arm, const Counts& counts);
/// Angles of the stylus D, E, F, rad; invalid without stylus encoders.
dvec3 stylus_angles(const Arm& arm, const Counts& counts);
/// Pose of the stylus tip in the base frame H. The orientation was not verified on hardware.
Pose stylus_pose(const Arm& arm, const Counts& counts);
dvec3 stylus_position(const Arm& arm, const dvec3& theta);
/// True angles of the bodies A, B, C: body_angles(), corrected if the arm was measured.
dvec3 true_angles(const Arm& arm, const Counts& counts);
/// Columns ∂p/∂A, ∂p/∂B, ∂p/∂C, m/rad.
glm::dmat3 jacobian(const Arm& arm, const dvec3& theta);
/// Motion of the tip per encoder count in the home position, m: root of the sum of squares over A, B and C.
double position_step(const Arm& arm);
/// Torques on A, B, C that balance the arm's weight, N·m; zero if the preset states no masses.
dvec3 gravity_torque(const Arm& arm, const dvec3& theta);

struct Currents {
  dvec3 amperes{0};
  bool clipped = false;
};
/// Motor currents for a force f_S_H (N, frame H) plus torques `holding` (N·m). If one current exceeds the limit, all
/// are scaled down together, so the direction of the force does not change.
Currents motor_currents(const Arm& arm, const dvec3& theta, const dvec3& f_S_H, const dvec3& holding);

}  // namespace typodont::haptics
