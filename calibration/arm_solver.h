// Geometry of the haptic arm, from captures of a tip that rests in a socket or on a plate. Undetermined parameters keep
// their values and are listed. SI. Not for real time.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// As reported by the encoders A to F, before calibration.
struct ArmReading {
  std::array<double, 6> angle{};  // rad, angles of the joints A to F
};

/// Serial arm such as WoodenHaptics or Polhem, with their published kinematics. B and C from the vertical; x to the
/// user, y right, z up. True angle = scale · reading + offset.
struct ArmGeometry {
  double base = 0.080, upper = 0.205, fore = 0.245;  // m: La, Lb, Lc
  // m, origin of H from the arm's foot
  dvec3 origin{0.220, 0, 0.080};
  std::array<double, 6> offset{};        // rad, encoders A to F
  std::array<double, 3> scale{1, 1, 1};  // encoders A, B, C
  dvec3 tip_S{0.12, 0, 0};               // m from the wrist's centre; x along the stylus
};

inline constexpr std::size_t kArmParameters = 18;
/// In the order of to_vector.
std::span<const char* const> arm_parameter_names();
/// Plausible errors: 1 mm, 1°, 0.5 %. Parameters are scaled by them.
std::array<double, kArmParameters> arm_parameter_scales();
std::array<double, kArmParameters> to_vector(const ArmGeometry& geometry);
ArmGeometry to_geometry(const std::array<double, kArmParameters>& parameters);

// X_HS; S has its origin in the wrist's centre.
Pose stylus_pose(const ArmGeometry& geometry, const ArmReading& reading);
// of the tip, m, frame H
dvec3 tip_position(const ArmGeometry& geometry, const ArmReading& reading);
/// Derivatives of the tip in the order of to_vector: m per m, m per rad, m per scale.
std::array<dvec3, kArmParameters> tip_derivatives(const ArmGeometry& geometry, const ArmReading& reading);

/// A resting tip. One group: the same socket (`known` empty) or plate.
struct ArmCapture {
  int group = 0;
  std::optional<dvec3> known;  // m in the plate's frame; empty for a socket
  ArmReading reading;
};

struct ArmParameter {
  std::string name;
  double before = 0, after = 0;  // SI
  /// SI; the plausible error if undetermined
  double sigma = 0;
  // 0..1, reduction of the plausible error
  double determined = 0;
};

struct ArmResult {
  ArmGeometry geometry;
  std::vector<ArmParameter> parameters;
  // what the captures do not determine
  std::vector<std::string> not_observable;
  // m, rms distance between computed and true tip
  double before_rms = 0, after_rms = 0;
  double sigma = 0;  // m per axis, of a capture
  int degrees_of_freedom = 0;
  std::vector<std::size_t> rejected;  // indices of the rejected captures
  std::vector<double> residuals;      // m, residual of each capture
  // why no arm of this type explains the captures; empty: it does
  std::string misfit;
};

/// Starts at `nominal`. Throws Error without captures, or if a group mixes sockets and plates.
ArmResult solve_arm(std::span<const ArmCapture> captures, const ArmGeometry& nominal);

}  // namespace typodont::calibration
