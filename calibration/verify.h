// Verifies a calibration with new points, and checks for drift with three points at the start of a session. Metres; any
// thread.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "calibration/registration_solver.h"

namespace typodont::calibration {

struct Tolerance {
  // m, largest accepted rms and maximum of the systematic co-location error over the workspace
  double rms = 0.5e-3, worst = 1e-3;
};

/// A point of the error map.
struct MapPoint {
  dvec3 p_D{0, 0, 0}, error_D{0, 0, 0};  // m, frame D of the display: position, and co-location error there
  double sigma = 0;                      // m, rms uncertainty of the error
};

struct VerifyResult {
  int points = 0;
  // m, touch errors including noise: rms, mean, maximum
  double raw_rms = 0, raw_mean = 0, raw_worst = 0;
  double noise = 0;  // m per axis, noise of the touches after subtraction of the smooth error field
  // Rms and maximum of the systematic error in the workspace, m: a smooth field fitted to the errors of the touches,
  // without the part that their noise adds.
  double rms = 0, worst = 0;
  double uncertainty = 0;  // m, rms error of the fitted field because of the touches' noise
  int order = 0;           // order of the polynomial of the fitted error field: 0 constant, 1 affine, 2 quadratic
  Box workspace_D;
  std::vector<MapPoint> map;          // error at 9×9×9 grid points; x changes fastest
  std::vector<double> residuals;      // m, residual of each touch
  std::vector<std::size_t> outliers;  // indices of the touches whose error differs much from the fitted error field
  Tolerance tolerance;
  bool pass = false;
  std::string verdict;  // the result as one sentence
};

/// Evaluates a registration with pairs of points: p_H was touched, p_D was shown. Throws Error without pairs.
VerifyResult verify(std::span<const dvec3> p_H, std::span<const dvec3> p_D, const Pose& X_DH,
                    const Tolerance& tolerance, const Box& workspace_D);

struct DriftResult {
  double shift = 0;  // m, displacement of the point `center_H` since the calibration
  double turn = 0;   // rad, rotation of the touched points since the calibration
  double worst = 0;  // m, largest displacement of one of the touched points
  double sigma = 0;  // m, rms displacement of a point that the noise of the touches alone would cause
  // True if `worst` exceeds the tolerance, and the displacements are statistically significant (99 %).
  bool drifted = false;
  std::string verdict;
};

/// Compares current touches of marks (`now_H`) with those of the same marks at the calibration (`then_H`).
DriftResult check_drift(std::span<const dvec3> then_H, std::span<const dvec3> now_H, double touch_sigma,
                        const dvec3& center_H, double tolerance = 0.3e-3);

}  // namespace typodont::calibration
