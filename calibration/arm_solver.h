// Calibrates the geometry of the haptic arm from captures of a tip that rests in a socket or on a plate. Parameters
// that the captures do not determine keep their values, and are listed. SI units. Not for real time.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// Readings of the encoders A to F before calibration.
struct ArmReading {
  std::array<double, 6> angle{};  // rad, angles of the joints A to F
};

/// Serial arm with the published kinematics of WoodenHaptics and Polhem. The angles of the joints B and C are measured
/// from the vertical; x points to the user, y right, z up. True angle = scale · reading + offset.
struct ArmGeometry {
  double base = 0.080, upper = 0.205, fore = 0.245;  // m, lengths of the links La, Lb, Lc
  // Origin of the haptic frame H relative to the arm's foot, m.
  dvec3 origin{0.220, 0, 0.080};
  std::array<double, 6> offset{};        // rad, added to the scaled readings of the encoders A to F
  std::array<double, 3> scale{1, 1, 1};  // factors on the readings of the encoders A, B, C
  dvec3 tip_S{0.12, 0, 0};               // m, position of the tip relative to the wrist's centre; x along the stylus
};

inline constexpr std::size_t kArmParameters = 18;
/// Names of the parameters in the order of to_vector.
std::span<const char* const> arm_parameter_names();
/// Unit of a parameter in files and reports: its value in SI, its name ("" for a factor), its suffix in keys.
struct ArmUnit {
  double si;
  const char *name, *suffix;
};
ArmUnit arm_parameter_unit(std::string_view parameter);
/// Plausible errors of the parameters before calibration: 1 mm, 1°, 0.5 %. The solver scales parameters by them.
std::array<double, kArmParameters> arm_parameter_scales();
std::array<double, kArmParameters> to_vector(const ArmGeometry& geometry);
ArmGeometry to_geometry(const std::array<double, kArmParameters>& parameters);

// Pose X_HS of the stylus; S has its origin in the wrist's centre.
Pose stylus_pose(const ArmGeometry& geometry, const ArmReading& reading);
// Position of the tip in the haptic frame H, m.
dvec3 tip_position(const ArmGeometry& geometry, const ArmReading& reading);
/// Derivatives of the tip's position with respect to the arm's parameters, in the order of to_vector(): m per m, m per
/// rad, m per unit of scale.
std::array<dvec3, kArmParameters> tip_derivatives(const ArmGeometry& geometry, const ArmReading& reading);

/// Capture of a resting tip. Captures of one group belong to the same socket (`known` is empty) or the same plate.
struct ArmCapture {
  int group = 0;
  std::optional<dvec3> known;  // m, position on the plate in the plate's frame; empty for a socket
  ArmReading reading;
};

struct ArmParameter {
  std::string name;
  double before = 0, after = 0;  // SI, value of the parameter before and after the calibration
  /// Standard deviation, SI; if the parameter is not determined, its plausible error.
  double sigma = 0;
  // How far the captures reduce the parameter's plausible error: 0 not at all, 1 completely.
  double determined = 0;
};

struct ArmResult {
  ArmGeometry geometry;
  std::vector<ArmParameter> parameters;
  // Parameters that the captures do not determine.
  std::vector<std::string> not_observable;
  // Root mean square distance between computed and true tip, m.
  double before_rms = 0, after_rms = 0;
  double sigma = 0;  // m per axis, standard deviation of a capture
  int degrees_of_freedom = 0;
  std::vector<std::size_t> rejected;  // indices of the rejected captures
  std::vector<double> residuals;      // m, residual of each capture
  // Reason why no arm of this type fits the captures; empty: an arm of this type fits.
  std::string misfit;
};

/// Calibrates the arm, starting from `nominal`. Throws Error without captures, or if a group mixes sockets and plates.
ArmResult solve_arm(std::span<const ArmCapture> captures, const ArmGeometry& nominal);

}  // namespace typodont::calibration
