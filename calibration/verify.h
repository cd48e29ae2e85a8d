// Does it hold: fresh points, never used before, and three points at the start of a session. Metres; any thread.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "calibration/registration_solver.h"

namespace typodont::calibration {

struct Tolerance {
  double rms = 0.5e-3, worst = 1e-3;  // m, of the systematic co-location error over the workspace
};

/// A point of the map.
struct MapPoint {
  dvec3 p_D{0, 0, 0}, error_D{0, 0, 0};  // m
  double sigma = 0;                      // m, rms of the estimate of the error
};

struct VerifyResult {
  int points = 0;
  double raw_rms = 0, raw_mean = 0, raw_worst = 0;  // m, of the touches as they are, noise included
  double noise = 0;                                 // m per axis, what no smooth error explains
  double rms = 0,
         worst =
             0;  // m, systematic error over the workspace: a smooth field through the touches, its own noise taken off
  double uncertainty = 0;  // m, rms of that noise
  int order = 0;           // of the field: 0 constant, 1 affine, 2 quadratic
  Box workspace_D;
  std::vector<MapPoint> map;          // 9×9×9, x fastest
  std::vector<double> residuals;      // m, of each touch
  std::vector<std::size_t> outliers;  // touches far off the field
  Tolerance tolerance;
  bool pass = false;
  std::string verdict;  // one sentence
};

/// Pairs (touched in H, shown in D) and the registration to be judged. Throws Error without a pair.
VerifyResult verify(std::span<const dvec3> p_H, std::span<const dvec3> p_D, const Pose& X_DH,
                    const Tolerance& tolerance, const Box& workspace_D);

struct DriftResult {
  double shift = 0;      // m, at `center`
  double turn = 0;       // rad
  double worst = 0;      // m, of the three points
  double sigma = 0;      // m, expected of `worst` from touch noise alone
  bool drifted = false;  // beyond the tolerance and beyond chance (99 %)
  std::string verdict;
};

/// The same marks touched at calibration and now.
DriftResult check_drift(std::span<const dvec3> then_H, std::span<const dvec3> now_H, double touch_sigma,
                        const dvec3& center_H, double tolerance = 0.3e-3);

}  // namespace typodont::calibration
