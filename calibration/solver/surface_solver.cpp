#include "calibration/surface_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "calibration/solver/eigen_math.h"
#include "engine/base/error.h"
#include "engine/base/quantile.h"
#include "engine/base/units.h"

namespace typodont::calibration {

namespace {

// Seven unknowns: rotation vector, translation, offset.
using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

constexpr std::size_t kMinPoints = 100;
constexpr int kMaxRounds = 200;
// A point is used only if the cosine between both surfaces' normals is at least this.
constexpr double kFaces = 0.5;
constexpr double kTukey = 4.685;  // Tukey's constant: 95 % efficiency for normal errors
// σ / median |residual| for normal errors.
constexpr double kPerMedian = 1.4826;
// Per round, the limit of the residuals shrinks at most to this fraction of its last value.
constexpr double kShrink = 0.8;
constexpr double kStill = 1e-7;  // m, step below which the pose has converged
// Regularisation (ridge) of the offset, because some shapes, for example a corner, do not determine the offset.
constexpr double kOffsetRidge = 1e-3;

dquat rotation(const dvec3& vector) {
  const double angle = glm::length(vector);
  return angle > 0 ? glm::angleAxis(angle, vector / angle) : dquat(1, 0, 0, 0);
}

struct Residual {
  std::size_t point;
  double distance;  // m, signed distance of the point from the surface in frame D
  dvec3 p_D, n_D;
};

class SurfaceFit {
 public:
  SurfaceFit(std::span<const SurfacePoint> points, const SurfaceField& field, const SurfaceOptions& options)
      : points_(points), field_(field), options_(options) {
    for (const SurfacePoint& s : points) centroid_S_ += s.p_S / static_cast<double>(points.size());
    for (const SurfacePoint& s : points) {
      const dvec3 arm = s.p_S - centroid_S_;
      radius_ += glm::dot(arm, arm) / static_cast<double>(points.size());
    }
    radius_ = std::sqrt(radius_);
  }

  SurfaceRegistration solve(const Pose& start) {
    X_ = start;
    limit_ = options_.start_reach;
    for (result_.rounds = 1; result_.rounds <= kMaxRounds; ++result_.rounds) {
      look();
      if (residuals_.size() < kMinPoints / 2) break;
      const double target = robust_limit();
      const bool settled = limit_ <= target;
      limit_ = std::max(target, kShrink * limit_);
      const double step = move();
      if (!std::isfinite(step)) break;
      if (settled && step < kStill) {
        result_.converged = true;
        break;
      }
    }
    look();
    measure();
    judge(start);
    return std::move(result_);
  }

 private:
  void look() {
    residuals_.clear();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const dvec3 p_D = X_ * points_[i].p_S;
      const FieldSample at = field_(p_D);
      const double slope = glm::length(at.gradient);
      if (!at.known || !(slope > 0.1)) continue;
      const dvec3 n_D = at.gradient / slope;
      if (std::abs(at.distance) > options_.start_reach || glm::dot(n_D, X_.rotate(points_[i].n_S)) < kFaces) continue;
      residuals_.push_back({i, at.distance, p_D, n_D});
    }
  }

  /// Limit of the residuals, from the median of used residuals, m.
  double robust_limit() const {
    std::vector<double> within;
    for (const Residual& r : residuals_) {
      const double d = std::abs(r.distance - offset_);
      if (d <= limit_) within.push_back(d);
    }
    const double least = 0.25 * options_.resolution;
    return std::max(least, kTukey * kPerMedian * lower_quantile(std::move(within), 0.5));
  }

  double weight(double residual) const {
    const double u = residual / limit_;
    return std::abs(u) < 1 ? (1 - u * u) * (1 - u * u) : 0;
  }
  Vector7 row(const Residual& r) const {
    Vector7 J;
    // Rotation about the centroid, multiplied by radius_, so that all unknowns are lengths.
    J << eigen(glm::cross(r.p_D - X_ * centroid_S_, r.n_D)) / radius_, eigen(r.n_D), -1;
    return J;
  }
  Matrix7 information() const {
    Matrix7 H = Matrix7::Zero();
    double total = 0;
    for (const Residual& r : residuals_) {
      const double w = weight(r.distance - offset_);
      const Vector7 J = row(r);
      H += w * J * J.transpose();
      total += w;
    }
    H(6, 6) += kOffsetRidge * total;
    return H;
  }

  /// Makes one Gauss–Newton step and returns its size, m.
  double move() {
    Vector7 g = Vector7::Zero();
    double total = 0;
    for (const Residual& r : residuals_) {
      const double w = weight(r.distance - offset_);
      g += w * (r.distance - offset_) * row(r);
      total += w;
    }
    g(6) += kOffsetRidge * total * offset_;
    const Vector7 x = -definite_solution(information(), g);
    const dvec3 centre_D = X_ * centroid_S_;
    const dquat turn = rotation(dvec3(x(0), x(1), x(2)) / radius_);
    X_.R = glm::normalize(turn * X_.R);
    X_.p = centre_D + dvec3(x(3), x(4), x(5)) - X_.R * centroid_S_;
    offset_ += x(6);
    return x.norm();
  }

  void measure() {
    result_.X_DS = X_;
    result_.offset = offset_;
    result_.near = residuals_.size();
    std::vector<double> agreeing;
    for (const Residual& r : residuals_) {
      if (weight(r.distance - offset_) > 0) agreeing.push_back(std::abs(r.distance - offset_));
    }
    if (residuals_.empty()) return;
    result_.agreement = static_cast<double>(agreeing.size()) / static_cast<double>(residuals_.size());
    result_.area = static_cast<double>(agreeing.size()) * options_.point_area;
    result_.median = lower_quantile(agreeing, 0.5);
    result_.most_of = lower_quantile(agreeing, 0.95);

    // Cluster-robust sandwich estimator: residuals are first summed over cells, because errors of neighbours are
    // correlated.
    std::map<std::tuple<int, int, int>, Vector7> cells;
    for (const Residual& r : residuals_) {
      const dvec3 cell = glm::floor(points_[r.point].p_S / options_.correlation);
      const double d = r.distance - offset_;
      auto [at, added] = cells.try_emplace(
          {static_cast<int>(cell.x), static_cast<int>(cell.y), static_cast<int>(cell.z)}, Vector7::Zero());
      at->second += weight(d) * d * row(r);
    }
    const auto count = static_cast<double>(cells.size());
    const Matrix7 H = information();
    const Vector7 determined = eigen_of(Eigen::MatrixXd(H)).eigenvalues();
    if (count < 10 || !(determined(0) > 1e-9 * determined(6))) {
      undetermined_ = true;
      return;
    }
    Matrix7 scores = Matrix7::Zero();
    for (const auto& [cell, score] : cells) scores += score * score.transpose();
    const Matrix7 inverse = definite_solution(H, Matrix7::Identity());
    const Eigen::Matrix<double, 6, 6> C = (count / (count - 7) * inverse * scores * inverse).topLeftCorner<6, 6>();

    // Moves the reference from the scan's centroid to the origin of D: the translation changes by −θ × centre.
    Eigen::Matrix<double, 6, 6> to_origin = Eigen::Matrix<double, 6, 6>::Identity();
    to_origin.topLeftCorner<3, 3>() /= radius_;
    to_origin.bottomLeftCorner<3, 3>() = cross_matrix(X_ * centroid_S_) / radius_;
    const Eigen::Matrix<double, 6, 6, Eigen::RowMajor> covariance = to_origin * C * to_origin.transpose();
    std::copy(covariance.data(), covariance.data() + 36, result_.covariance.begin());

    double sum = 0;
    for (const Residual& r : residuals_) {
      if (!(weight(r.distance - offset_) > 0)) continue;
      Eigen::Matrix<double, 3, 6> J;
      J << -cross_matrix(r.p_D - X_ * centroid_S_) / radius_, Eigen::Matrix3d::Identity();
      sum += (J * C * J.transpose()).trace();
    }
    result_.predicted_error = std::sqrt(sum / static_cast<double>(agreeing.size()));
  }

  void judge(const Pose& start) {
    std::string& why = result_.distrust;
    if (residuals_.size() < kMinPoints / 2 || result_.area < options_.min_area) {
      why = fmt::format(
          "{:.1f} mm² of the scan agree with the other surface, expected at least {:.0f} mm²: the start may be wrong",
          result_.area / kSquareMillimetre, options_.min_area / kSquareMillimetre);
    } else if (!result_.converged) {
      why = fmt::format("no convergence in {} rounds", kMaxRounds);
    } else if (result_.median > options_.resolution || result_.agreement < options_.min_agreement) {
      why = fmt::format(
          "{:.0f} % of the scan near the other surface agree with it within {:.2f} mm (median residual {:.3f} mm), "
          "expected at least {:.0f} % and a median below {:.2f} mm: it may be another mouth, or a wrong start",
          100 * result_.agreement, limit_ / kMillimetre, result_.median / kMillimetre, 100 * options_.min_agreement,
          options_.resolution / kMillimetre);
    } else if (undetermined_ || result_.predicted_error > options_.max_error) {
      why = undetermined_ ? "the surface does not determine the pose"
                          : fmt::format("the predicted error is {:.2f} mm, expected at most {:.2f} mm",
                                        result_.predicted_error / kMillimetre, options_.max_error / kMillimetre);
    } else if (const double moved = glm::length(X_ * centroid_S_ - start * centroid_S_); moved > kMaxMove) {
      why = fmt::format("the fine registration moved the scan by {:.1f} mm from the start, expected at most {:g} mm",
                        moved / kMillimetre, kMaxMove / kMillimetre);
    }
  }

  // Largest plausible motion from the start, m; farther could be the next tooth (5 mm).
  static constexpr double kMaxMove = 3e-3;

  std::span<const SurfacePoint> points_;
  const SurfaceField& field_;
  const SurfaceOptions& options_;
  dvec3 centroid_S_{0};
  double radius_ = 0;  // m, rms distance of the points from their centroid
  Pose X_;
  // Offset between the surfaces, and limit of the residuals, m.
  double offset_ = 0, limit_ = 0;
  std::vector<Residual> residuals_;
  bool undetermined_ = false;
  SurfaceRegistration result_;
};

}  // namespace

SurfaceRegistration register_surface(std::span<const SurfacePoint> points, const SurfaceField& field,
                                     const Pose& X_DS_start, const SurfaceOptions& options) {
  if (points.size() < kMinPoints) {
    throw Error(fmt::format("surface registration: found {} points, expected at least {}", points.size(), kMinPoints));
  }
  return SurfaceFit(points, field, options).solve(X_DS_start);
}

}  // namespace typodont::calibration
