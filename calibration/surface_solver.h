// Rigid registration of a scanned surface S to the distance field of a surface D, from an approximate pose.
// Point-to-plane residuals with robust weights. Metres. Not for real time.
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

/// Value of surface D's distance field at one point. `known`: the nearest point of the surface is close enough, and
/// belongs to the part of D that is registered.
struct FieldSample {
  bool known = false;
  double distance = 0;  // m, point's distance from the nearest surface; negative inside
  dvec3 gradient{0};    // gradient of the distance (no unit), expressed in frame D
};
using SurfaceField = std::function<FieldSample(const dvec3& p_D)>;

struct SurfaceOptions {
  double point_area = 1e-6;  // m², area that a point represents
  // Largest residual that is used in the first round, m; the limit decreases in later rounds.
  double start_reach = 1.5e-3;
  double resolution = 0.3e-3;  // m, voxel size of the field; residuals of a good fit are smaller than this
  double correlation = 2e-3;   // m, errors closer to each other than this are correlated
  // Agreeing points of a trusted result represent at least this area, m².
  double min_area = 30e-6;
  double min_agreement = 0.7;  // trusted results have at least this `agreement`
  double max_error = 0.2e-3;   // m, trusted results have at most this `predicted_error`
};

struct SurfaceRegistration {
  Pose X_DS;
  bool converged = false;
  int rounds = 0;
  // Number of points near D: the distance is known and below start_reach, and the normals differ by less than 60°.
  std::size_t near = 0;
  double agreement = 0;  // fraction of the `near` points whose residual is small enough to be used
  double area = 0;       // m², area of the agreeing points
  /// Mean distance of the scanned surface from the field's surface, m, positive outside the tissue; estimated together
  /// with the pose.
  double offset = 0;
  // Quantiles of the absolute residual over the agreeing points, after `offset` was subtracted.
  double median = 0, most_of = 0;  // m; 50 % and 95 % quantile
  /// Covariance of a small motion in frame D after X_DS, 6×6, row-major: rotation vector about the origin of D (rad),
  /// then translation (m). Neighbours' residuals are correlated: cluster-robust estimator (Liang & Zeger 1986).
  std::array<double, 36> covariance{};
  double predicted_error = 0;  // m, rms error of agreeing points, predicted by covariance
  std::string distrust;        // one sentence, the reason why the result cannot be trusted; empty: it can be trusted
};

/// Registers by Gauss–Newton with Tukey's weights. The limit of the residuals decreases from start_reach to a value
/// from their median. Throws Error for fewer than 100 points.
SurfaceRegistration register_surface(std::span<const SurfacePoint> points, const SurfaceField& field,
                                     const Pose& X_DS_start, const SurfaceOptions& options = {});

}  // namespace typodont::calibration
