// Calibrates the haptic arm's geometry. In each capture, the stylus tip rests in a fixed socket or touches a known
// point of a plate. Parameters that the captures do not determine keep their values and are listed. SI units. Not for
// real-time threads.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// Joint angles A to F as the encoders report them, before calibration.
struct ArmReading {
  std::array<double, 6> angle{};  // rad, angles of the joints A to F
};

/// Geometry of a serial arm such as WoodenHaptics or Polhem, with their published kinematics. Angles B and C are
/// measured from the vertical. x points towards the user, y right, z up. True angle = scale · reading + offset.
struct ArmGeometry {
  double base = 0.080, upper = 0.205, fore = 0.245;  // m, lengths of base (La), upper arm (Lb) and forearm (Lc)
  // m, position of the origin of frame H (the haptic base), measured from the arm's foot
  dvec3 origin{0.220, 0, 0.080};
  std::array<double, 6> offset{};        // rad, offsets of the encoders of the joints A to F
  std::array<double, 3> scale{1, 1, 1};  // scale factors of the encoders of the joints A, B, C
  dvec3 tip_S{0.12, 0, 0};  // m, position of the stylus tip relative to the wrist's centre; x points along the stylus
};

inline constexpr std::size_t kArmParameters = 18;
/// Returns the names of the parameters in the order of to_vector, for example "upper link".
std::span<const char* const> arm_parameter_names();
/// Returns the plausible error of each parameter: 1 mm for lengths, 1° for angles, 0.5 % for scales. The solver divides
/// each parameter and its uncertainty by this plausible error.
std::array<double, kArmParameters> arm_parameter_scales();
std::array<double, kArmParameters> to_vector(const ArmGeometry& geometry);
ArmGeometry to_geometry(const std::array<double, kArmParameters>& parameters);

// Returns X_HS: the pose of frame S (the stylus, with its origin in the wrist's centre) in frame H of the haptic base.
Pose stylus_pose(const ArmGeometry& geometry, const ArmReading& reading);
// returns the position (m) of the stylus tip in frame H of the haptic base
dvec3 tip_position(const ArmGeometry& geometry, const ArmReading& reading);
/// Returns the derivatives of the tip's position with respect to all parameters, in the order of to_vector. Units: m
/// per m for a length, m per rad for an angle, m for a scale factor.
std::array<dvec3, kArmParameters> tip_derivatives(const ArmGeometry& geometry, const ArmReading& reading);

/// One capture (recorded touch) of the resting tip. Captures of the same group come from the same socket (`known` is
/// empty) or the same plate (`known` is the position on the plate).
struct ArmCapture {
  int group = 0;
  std::optional<dvec3> known;  // m, position on the plate, in its frame; empty for a socket, whose position is unknown
  ArmReading reading;
};

struct ArmParameter {
  std::string name;
  double before = 0, after = 0;  // values of the parameter before and after the calibration, in SI units
  /// standard deviation of the parameter, SI units; if the captures do not determine the parameter, its plausible error
  double sigma = 0;
  // 0..1: fraction by which the captures reduced the parameter's uncertainty, compared with its plausible error
  double determined = 0;
};

struct ArmResult {
  ArmGeometry geometry;
  std::vector<ArmParameter> parameters;
  // text that names the parameters, or combinations of parameters, that the captures do not determine
  std::vector<std::string> not_observable;
  // m; at each capture, the computed position of the tip is compared with the position where the tip rested. The values
  // are the root mean square of these distances, before and after the calibration.
  double before_rms = 0, after_rms = 0;
  double sigma = 0;  // m per axis, standard deviation of the noise of a capture
  int degrees_of_freedom = 0;
  std::vector<std::size_t> rejected;  // indices of the rejected captures
  std::vector<double> residuals;      // m, residual of each capture
  // reason why an arm of this type cannot explain the captures (then do not use the result); empty: it can explain them
  std::string misfit;
};

/// Calibrates an arm whose geometry is nearly `nominal`. Throws Error if there is no capture, or if a group contains
/// both sockets and plate points.
ArmResult solve_arm(std::span<const ArmCapture> captures, const ArmGeometry& nominal);

}  // namespace typodont::calibration
