// Serial arm with the published kinematics of WoodenHaptics and Polhem: bodies A (angle about z), B and C (angles from
// the vertical), stylus joints D, E, F. Frame H: x to the user, y right, z up. SI units. Any thread.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "engine/base/pose.h"

namespace typodont {

class Json;

/// Angles of the joints A to F as the encoders state them.
struct ArmReading {
  std::array<double, 6> angle{};  // rad
};

struct ArmGeometry {
  double base = 0.080, upper = 0.205, fore = 0.245;  // m, lengths of the links La, Lb, Lc
  // Origin of the haptic frame H relative to the arm's foot, m.
  dvec3 origin{0.220, 0, 0.080};
  std::array<double, 6> offset{};        // rad, added to the scaled readings of the encoders A to F
  std::array<double, 3> scale{1, 1, 1};  // factors on the readings of the encoders A, B, C
  dvec3 tip_S{0.12, 0, 0};               // m, position of the tip relative to the wrist's centre; x along the stylus
  // rad/m; by how much B and C bend per metre of horizontal distance between joint and wrist
  std::array<double, 2> sag{0, 0};
};

/// The arm's true angles.
struct ArmJoints {
  std::array<double, 6> q{};       // rad, after scale, offset and sag
  std::array<double, 2> lever{};   // m, horizontal distance of the wrist from the joints B and C, without sag
  std::array<double, 2> before{};  // rad, angles B and C without sag
};
ArmJoints arm_joints(const ArmGeometry& arm, const ArmReading& reading);
/// Position of the wrist's centre in H, m. `q`: true angles.
dvec3 wrist_position(const ArmGeometry& arm, const std::array<double, 6>& q);
/// Pose X_HS of the stylus; S has its origin in the wrist's centre.
Pose stylus_pose(const ArmGeometry& arm, const ArmReading& reading);
/// Position of the tip in H, m.
dvec3 tip_position(const ArmGeometry& arm, const ArmReading& reading);

inline constexpr std::size_t kArmParameters = 20;
/// Names of the parameters in the order of to_vector.
std::span<const char* const> arm_parameter_names();
/// Unit of a parameter in files and reports: its value in SI, its name ("" for a factor), its suffix in keys.
struct ArmUnit {
  double si;
  const char *name, *suffix;
};
ArmUnit arm_parameter_unit(std::string_view parameter);
std::array<double, kArmParameters> to_vector(const ArmGeometry& geometry);
ArmGeometry to_geometry(const std::array<double, kArmParameters>& parameters);
/// Key of a parameter in a rig file's block calibration.arm, for example "tip_x_mm".
std::string arm_parameter_key(std::string name);
/// Reads a block calibration.arm; missing keys keep their defaults. Throws Error.
ArmGeometry read_arm_geometry(const Json& json);

}  // namespace typodont
