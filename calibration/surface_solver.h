// Rigid registration of a scanned surface S to the distance field of another surface D, from an approximate initial
// pose. Uses point-to-plane residuals with robust weights. Metres. Not for real-time threads.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// A point of the scanned surface. All points represent the same area.
struct SurfacePoint {
  dvec3 p_S;
  dvec3 n_S;  // unit normal of the scanned surface in frame S, pointing out of the tissue
};

/// The distance field at a point of frame D. `known`: true if the nearest surface is close enough and belongs to the
/// part that is registered.
struct FieldSample {
  bool known = false;
  double distance = 0;  // m, distance of the point from the nearest surface; negative inside
  dvec3 gradient{0};    // gradient of the distance (no unit), expressed in frame D
};
using SurfaceField = std::function<FieldSample(const dvec3& p_D)>;

struct SurfaceOptions {
  double point_area = 1e-6;  // m², area that a point represents
  // m, largest residual that is used in the first round; in later rounds this limit is smaller, because the residuals
  // decrease
  double start_reach = 1.5e-3;
  double resolution = 0.3e-3;  // m, voxel size of the field; residuals of a good fit are smaller than this
  double correlation = 2e-3;   // m, distance over which errors of the two surfaces are correlated
  // m²; the result is not trusted if the area of the agreeing points is smaller than this
  double least_area = 30e-6;
  double least_agreement = 0.7;  // the result is not trusted if `agreement` is smaller than this
  double most_error = 0.2e-3;    // m; the result is not trusted if `predicted_error` is larger than this
};

struct SurfaceRegistration {
  Pose X_DS;
  bool converged = false;
  int rounds = 0;
  // Number of points of the scan that lie near the surface D: the distance field is known there, the distance is below
  // start_reach, and the normals of the two surfaces differ by less than 60°.
  std::size_t near = 0;
  double agreement = 0;  // fraction of the `near` points whose residual is small enough to be used
  double area = 0;       // m², area of the agreeing points
  /// m, mean distance of the scanned surface from the surface of the field, positive outside the tissue; it is
  /// estimated together with the pose
  double offset = 0;
  // Quantiles of |residual| over the agreeing points, after the offset was subtracted.
  double median = 0, most_of = 0;  // m; median: 50 % of the points are below it; most_of: 95 % of the points
  /// Row-major 6×6 covariance of a small motion in frame D, after the pose X_DS: rotation vector about the origin of D
  /// (rad), then translation (m). Residuals of neighbouring points are correlated, so the covariance is computed from
  /// sums over cells of size `correlation` (cluster-robust "sandwich" estimator, Liang & Zeger 1986).
  std::array<double, 36> covariance{};
  double predicted_error = 0;  // m, rms error at the agreeing points, predicted by the covariance
  std::string distrust;        // one sentence, the reason why the result cannot be trusted; empty: it can be trusted
};

/// Registers by Gauss–Newton with Tukey's weights. The largest residual that is used decreases from start_reach to a
/// value that is computed from the median residual. Throws Error for fewer than 100 points.
SurfaceRegistration register_surface(std::span<const SurfacePoint> points, const SurfaceField& field,
                                     const Pose& X_DS_start, const SurfaceOptions& options = {});

}  // namespace typodont::calibration
