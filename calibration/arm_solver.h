// Calibrates the geometry of the haptic arm from captures of a tip that rests in a socket or on a plate. Parameters
// that the captures do not determine keep their values, and are listed. SI units. Not for real time.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/arm_geometry.h"

namespace typodont::calibration {

/// Plausible errors of the parameters before calibration: 1 mm, 1°, 0.5 %, 1°/m. The solver scales parameters by them.
std::array<double, kArmParameters> arm_parameter_scales();
/// Derivatives of the tip's position with respect to the arm's parameters, in the order of to_vector(): m per m, m per
/// rad, m per unit of scale, m per rad/m.
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
