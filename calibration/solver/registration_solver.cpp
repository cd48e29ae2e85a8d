#include "calibration/registration_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "calibration/solver/agreement.h"
#include "calibration/solver/eigen_math.h"
#include "calibration/solver/near_rival.h"
#include "calibration/solver/no_rigid_motion.h"
#include "calibration/statistics.h"
#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::calibration {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A split into two motions is accepted if the probability that it is due to chance is below this.
constexpr double kSplitChance = 1e-3;
// If adding pairs increases the noise by more than this factor, the added pairs were wrong.
constexpr double kNoNoisier = 1.5;
constexpr double kUndetermined = 1e16;  // value of `condition` for an undetermined rotation; beyond double precision
constexpr double kUniformAngleVariance = kPi * kPi / 3;

struct Scatter {
  Vector3d values;  // m², sums of squares about the centroid, ascending
  Matrix3d axes;    // principal axes of the points in the haptic frame H, as columns
};

Scatter scatter_of(Points p_H, const Indices& pairs, const dvec3& centroid) {
  Matrix3d sum = Matrix3d::Zero();
  for (const std::size_t i : pairs) {
    const Vector3d h = eigen(p_H[i] - centroid);
    sum += h * h.transpose();
  }
  const auto solver = eigen_of(sum);
  Scatter scatter{solver.eigenvalues().cwiseMax(0), solver.eigenvectors()};
  // Rounding makes the small eigenvalues inexact, so they are summed again from the coordinates along their axes.
  scatter.values.head<2>().setZero();
  for (const std::size_t i : pairs) {
    const Vector3d across = scatter.axes.transpose() * eigen(p_H[i] - centroid);
    scatter.values[0] += across[0] * across[0];
    scatter.values[1] += across[1] * across[1];
  }
  return scatter;
}

/// Second moment of a filled box about the centroid, m².
Matrix3d second_moment(const Box& box_H, const dvec3& centroid_H) {
  const Vector3d size = eigen(box_H.high - box_H.low), offset = eigen(0.5 * (box_H.high + box_H.low) - centroid_H);
  return Matrix3d((size.cwiseProduct(size) / 12).asDiagonal()) + offset * offset.transpose();
}

std::string words(const dvec3& v) {
  return fmt::format("({:.3f}, {:.3f}, {:.3f})", v.x, v.y, v.z);
}

/// Steps of a registration: agreement, rivals, noise, undetermined rotations, covariance.
class Registration {
 public:
  Registration(Points p_H, Points p_D, const RegistrationOptions& options)
      : p_H_(p_H), p_D_(p_D), options_(options), n_(p_H.size()), rounding_(rounding_of(p_H, p_D)), everyone_(n_) {
    std::iota(everyone_.begin(), everyone_.end(), 0u);
  }

  RegistrationResult solve() {
    agree();
    if (options_.reject_outliers && consensus_ && !exact_) part_near_motions();
    if (consensus_ && result_.rivals.empty()) find_rivals();
    result_.X_DH = fit_.X_DH;
    result_.inliers = fit_.pairs;
    result_.outliers = outliers();
    for (std::size_t i = 0; i < n_; ++i) result_.residuals.push_back(glm::length(fit_.X_DH * p_H_[i] - p_D_[i]));
    if (consensus_ && result_.rivals.empty() && fit_.pairs.size() >= 4) check_three_outliers();
    estimate_noise();
    find_degeneracy();
    test_rigidity();
    estimate_uncertainty();
    return std::move(result_);
  }

 private:
  double dof() const { return 3 * static_cast<double>(fit_.pairs.size()) - 6; }

  Indices outliers() const {
    Indices rest;
    std::set_difference(everyone_.begin(), everyone_.end(), fit_.pairs.begin(), fit_.pairs.end(),
                        std::back_inserter(rest));
    return rest;
  }

  // Largest plausible residual of a correct pair, m.
  double reach(double sigma, double dof) const {
    const double p = 1 - options_.false_alarm / static_cast<double>(n_);
    return std::max(rounding_, options_.known_sigma > 0 ? options_.known_sigma * std::sqrt(chi_squared_quantile(p, 3))
                                                        : sigma * std::sqrt(3 * f_quantile(p, 3, std::max(1.0, dof))));
  }

  // Finds the pairs that agree on one rigid motion.
  void agree() {
    fit_ = fit_to(p_H_, p_D_, everyone_);
    exact_ = fit_.sse <= static_cast<double>(n_) * rounding_ * rounding_;
    if (!options_.reject_outliers || n_ < 4 || exact_) return;
    Agreement best = max_agreement(p_H_, p_D_, options_, 3);
    consensus_ = best.log_nfa < 0;
    if (consensus_) fit_ = std::move(best.fit);
  }

  // Takes pairs with residuals below `limit` (m) and refits, until nothing changes.
  Fit take_in(Fit fit, double limit) const {
    for (int round = 0; round < 20; ++round) {
      Indices inside;
      for (std::size_t i = 0; i < n_; ++i) {
        if (glm::length(fit.X_DH * p_H_[i] - p_D_[i]) <= limit) inside.push_back(i);
      }
      if (inside == fit.pairs || inside.size() < 4) break;
      fit = fit_to(p_H_, p_D_, std::move(inside));
    }
    return fit;
  }

  // Assigns each pair to one of two motions. The second motion is reported as a rival if many pairs follow it, or if it
  // is too similar to be separated; otherwise its pairs are outliers.
  bool part(Split& split, double dof) {
    const double limit = reach(split.sigma, dof);
    const double doubtful = assign_to_nearer(p_H_, p_D_, limit, split);
    const bool rival = 10 * followers(p_H_, p_D_, split.X_second, limit) >= 3 * split.first.size() || doubtful >= 0.02;
    // Refits the first motion with all pairs within the limit. If there is a rival, the refit must not add noise.
    fit_ = fit_to(p_H_, p_D_, split.first);
    Fit all = take_in(fit_, limit);
    if (!rival || (all.pairs.size() >= 4 && sigma_of(all) <= kNoNoisier * split.sigma)) fit_ = std::move(all);
    if (rival) result_.rivals.push_back({split.X_second, split.second});
    return rival;
  }

  // Looks for two similar motions. If the noise is known: only if the residuals contradict it (significance 5 %).
  void part_near_motions() {
    for (int round = 0; round < 3; ++round) {
      if (options_.known_sigma > 0) {
        const double sigma2 = options_.known_sigma * options_.known_sigma;
        const double excess = 1 - chi_squared_cdf(fit_.sse / sigma2, std::max(1.0, dof()));
        too_noisy_ = excess < 1e-4;
        if (excess > 0.05) return;
      }
      const double freedom = dof();
      auto split = split_in_two(p_H_, p_D_, fit_.pairs, options_.known_sigma, rounding_);
      if (!split || split->log_nfa > std::log(kSplitChance)) return;
      // Tests whether only a few pairs are wrong: then one motion fits all other pairs.
      const Fit cleared = take_in(fit_to(p_H_, p_D_, split->first), reach(split->sigma, freedom - 6));
      if (2 * cleared.pairs.size() > n_ && cleared.pairs.size() < fit_.pairs.size()) {
        const auto again = split_in_two(p_H_, p_D_, cleared.pairs, options_.known_sigma, rounding_);
        if (!again || again->log_nfa > std::log(kSplitChance)) {
          fit_ = cleared;
          return;
        }
      }
      if (part(*split, freedom - 6)) return;
    }
  }

  // Finds other motions with which several of the outliers agree.
  void find_rivals() {
    Indices rest = outliers();
    while (rest.size() >= 4) {
      std::vector<dvec3> h, d;
      for (const std::size_t i : rest) h.push_back(p_H_[i]), d.push_back(p_D_[i]);
      // Largest probability that pairs agree on another motion by chance. With 1e-3 (known noise), 4 pairs suffice.
      const double chance = options_.known_sigma > 0 ? 1e-3 : 1e-4;
      const auto [rival, log_nfa] = max_agreement(h, d, options_, 3 * fit_.pairs.size() / 10);
      // Pairs that agree only loosely are bad touches, not a second motion.
      const double sigma = std::max(sigma_of(fit_), rounding_);
      if (log_nfa > std::log(chance) || sigma_of(rival) > 4 * sigma) break;
      Indices pairs, left;
      for (const std::size_t i : rival.pairs) pairs.push_back(rest[i]);
      std::set_difference(rest.begin(), rest.end(), pairs.begin(), pairs.end(), std::back_inserter(left));
      Split split{fit_.X_DH, rival.X_DH, fit_.pairs, pairs, sigma, log_nfa};
      part(split, dof());
      rest = std::move(left);
    }
  }

  // The result is doubtful if three outliers agree on one motion within the noise of fit_, and this motion fits at
  // least 30 % as many pairs as fit_ contains.
  void check_three_outliers() {
    const Indices& rest = result_.outliers;
    if (rest.size() < 3 || rest.size() > 12) return;
    const double sigma = std::max(sigma_of(fit_), rounding_), known = options_.known_sigma;
    double least =
        known > 0 ? known * known * chi_squared_quantile(0.999, 3) : sigma * sigma * 3 * f_quantile(0.999, 3, dof());
    const double limit = reach(sigma, dof());
    for (std::size_t a = 0; a < rest.size(); ++a) {
      for (std::size_t b = a + 1; b < rest.size(); ++b) {
        for (std::size_t c = b + 1; c < rest.size(); ++c) {
          const Fit rival = fit_to(p_H_, p_D_, {rest[a], rest[b], rest[c]});
          if (rival.sse > least || 10 * followers(p_H_, p_D_, rival.X_DH, limit) < 3 * fit_.pairs.size()) continue;
          least = rival.sse;
          result_.rivals.assign(1, {rival.X_DH, rival.pairs});
        }
      }
    }
  }

  // Estimates the noise from the residuals of the agreeing pairs.
  void estimate_noise() {
    const auto k = static_cast<double>(fit_.pairs.size());
    for (const std::size_t i : fit_.pairs) result_.centroid_H += p_H_[i] / k;
    scatter_ = scatter_of(p_H_, fit_.pairs, result_.centroid_H);
    spread_ = (scatter_.values / k).cwiseSqrt();
    coincident_ = spread_[2] <= 4 * rounding_;
    collinear_ = spread_[1] <= std::max(4 * rounding_, 1e-9 * spread_[2]);
    const int rotations = coincident_ ? 0 : collinear_ ? 2 : 3;
    result_.degrees_of_freedom = static_cast<int>(3 * fit_.pairs.size()) - 3 - rotations;
    result_.fre_rms = std::sqrt(fit_.sse / k);
    const double freedom = result_.degrees_of_freedom;
    result_.sigma = options_.known_sigma > 0 ? options_.known_sigma
                    : freedom > 0            ? std::sqrt(fit_.sse / freedom)
                                             : std::numeric_limits<double>::quiet_NaN();
    // With few degrees of freedom, the estimate is uncertain; so the largest noise that is compatible with the
    // residuals (95 %) is used.
    noise_ = rounding_;
    if (options_.known_sigma > 0) {
      noise_ = std::max(noise_, options_.known_sigma);
    } else if (freedom > 0) {
      noise_ = std::max(noise_, std::sqrt(fit_.sse / chi_squared_quantile(0.05, freedom)));
    }
  }

  void find_degeneracy() {
    const dvec3 line = vec(scatter_.axes.col(2));
    Degeneracy& degeneracy = result_.degeneracy;
    if (!consensus_ && !collinear_) {
      degeneracy.defect = Defect::kNoConsensus;
      degeneracy.reason = "no set of pairs agrees on one rigid motion better than chance";
      undetermined_ = 3;
    } else if (spread_[2] <= std::max(4 * rounding_, 4 * noise_)) {
      degeneracy.defect = coincident_ || spread_[2] <= 1.5 * noise_ ? Defect::kCoincident : Defect::kNoise;
      degeneracy.reason = degeneracy.defect == Defect::kCoincident
                              ? "all points lie in one place: no rotation is determined"
                              : "the residuals are as large as the spread of the points: no rotation is determined";
      undetermined_ = 3;
    } else if (collinear_ || spread_[1] <= 4 * noise_) {
      degeneracy.defect = collinear_ || spread_[1] < 0.1 * spread_[2] ? Defect::kCollinear : Defect::kNoise;
      degeneracy.reason =
          fmt::format("{}: the rotation about the direction {} in H is not determined",
                      degeneracy.defect == Defect::kCollinear ? "the points lie on one line"
                                                              : "the noise is as large as the spread of the points",
                      words(line));
      undetermined_ = 1;
    }
    if (undetermined_ == 3) degeneracy.undetermined_H = {dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)};
    if (undetermined_ == 1) degeneracy.undetermined_H = {line};

    if (too_noisy_ && result_.rivals.empty() && degeneracy.defect == Defect::kNone) {
      const double times = std::sqrt(fit_.sse / result_.degrees_of_freedom) / options_.known_sigma;
      degeneracy = {
          Defect::kNoise,
          fmt::format("the residuals are {:.1f} times as large as the noise that was told: it is larger, or the "
                      "pairs do not all show one rigid motion",
                      times),
          {}};
    }
  }

  // Tests whether the points in frame D are a mirror image of those in frame H, or have other units.
  void test_rigidity() {
    Degeneracy& degeneracy = result_.degeneracy;
    const auto mirror = [&] {
      const dvec3 thin = vec(scatter_.axes.col(0));
      degeneracy = {
          Defect::kMirrored,
          fmt::format("D is a mirror image of H: no rigid motion exists; one axis is reversed, such as {} in H",
                      words(thin)),
          {thin}};
    };
    const auto rescale = [&](double scale, std::vector<dvec3> undetermined_H) {
      degeneracy = {
          Defect::kScaled,
          fmt::format("lengths in D are {:.4g} times those in H: no rigid motion exists; check the units", scale),
          std::move(undetermined_H)};
    };
    const bool doubtful = !consensus_ || 5 * fit_.pairs.size() < 4 * n_ || degeneracy.defect == Defect::kNoise ||
                          result_.fre_rms > 0.1 * spread_[2];
    if (doubtful && n_ >= 4 && mirror_fits_better(p_H_, p_D_, fit_, options_)) {
      mirror();
    } else if (n_ >= 2 && !coincident_ && (doubtful || n_ < 4)) {
      if (const auto scale = other_scale_by_median(p_H_, p_D_, rounding_)) rescale(*scale, degeneracy.undetermined_H);
    }
    if (degeneracy.defect != Defect::kNone) return;
    if (mirrored(p_H_, p_D_, fit_, rounding_)) {
      mirror();
    } else if (const auto scale = other_scale(p_H_, p_D_, fit_, rounding_)) {
      rescale(*scale, {});
    }
  }

  // Cramér–Rao bound: rotation σ² (Σ(|p|² I - p pᵀ))⁻¹ about the centroid, centroid σ²/N; then transformed to the
  // origin.
  void estimate_uncertainty() {
    const auto k = static_cast<double>(fit_.pairs.size());
    const double sigma2 = std::isfinite(result_.sigma) ? result_.sigma * result_.sigma : 0.0;
    const double total = scatter_.values.sum();
    Vector3d variance;
    for (int axis = 0; axis < 3; ++axis) {
      const bool open = undetermined_ == 3 || (undetermined_ == 1 && axis == 2);
      const double information = total - scatter_.values[axis];
      variance[axis] = open ? kUniformAngleVariance : std::min(kUniformAngleVariance, sigma2 / information);
    }
    const Matrix3d R = eigen(result_.X_DH.R);
    const Matrix3d axes_D = R * scatter_.axes;
    const Matrix3d C = axes_D * variance.asDiagonal() * axes_D.transpose();
    const Matrix3d lever = cross_matrix(R * eigen(result_.centroid_H));
    Eigen::Matrix<double, 6, 6, Eigen::RowMajor> covariance;
    // Translation t = c_D - R c_H (c: centroids), so a small rotation θ changes t by [R c_H] θ ([ ]: cross matrix).
    covariance.topLeftCorner<3, 3>() = C;
    covariance.topRightCorner<3, 3>() = C * lever.transpose();
    covariance.bottomLeftCorner<3, 3>() = lever * C;
    covariance.bottomRightCorner<3, 3>() = lever * C * lever.transpose() + sigma2 / k * Matrix3d::Identity();
    std::copy(covariance.data(), covariance.data() + 36, result_.covariance.begin());
    result_.condition =
        undetermined_ > 0
            ? kUndetermined
            : std::min(kUndetermined, std::sqrt((total - scatter_.values[0]) / (total - scatter_.values[2])));

    // Mean squared error in the workspace: 3σ²/N + tr(S) tr(C) - tr(S C). S: second moment; C: covariance of R.
    Box box = options_.workspace_H;
    if (box.low == box.high) {
      box.low = box.high = p_H_[fit_.pairs.front()];
      for (const std::size_t i : fit_.pairs)
        box.low = glm::min(box.low, p_H_[i]), box.high = glm::max(box.high, p_H_[i]);
    }
    const Matrix3d S = R * second_moment(box, result_.centroid_H) * R.transpose();
    result_.predicted_tre_rms = std::sqrt(std::max(0.0, 3 * sigma2 / k + S.trace() * C.trace() - (S * C).trace()));
  }

  Points p_H_, p_D_;
  const RegistrationOptions& options_;
  std::size_t n_;
  double rounding_;  // m, rounding error of the coordinates
  Indices everyone_;
  RegistrationResult result_;
  Fit fit_;
  bool exact_ = false, consensus_ = true, too_noisy_ = false;
  Scatter scatter_;
  Vector3d spread_;   // m, rms spread of the points along the main axes, ascending
  double noise_ = 0;  // m per axis, largest noise compatible with the residuals
  // coincident_: true if all points coincide; collinear_: true if they lie on a line.
  bool coincident_ = false, collinear_ = false;
  int undetermined_ = 0;  // number of rotations that the points do not determine
};

}  // namespace

const char* name(Defect defect) {
  constexpr const char* kNames[] = {"none", "coincident", "collinear", "noise", "mirrored", "scaled", "no_consensus"};
  return kNames[static_cast<int>(defect)];
}

RegistrationResult register_points(Points p_H, Points p_D, const RegistrationOptions& options) {
  const std::size_t n = p_H.size();
  if (n == 0) throw Error("registration: found no pair, expected at least one");
  if (n != p_D.size()) {
    throw Error(fmt::format("registration: found {} points in H and {} in D, expected as many", n, p_D.size()));
  }
  return Registration(p_H, p_D, options).solve();
}

double predicted_tre(const RegistrationResult& result, const dvec3& p_H) {
  using Covariance = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
  const Eigen::Map<const Covariance> covariance(result.covariance.data());
  Eigen::Matrix<double, 3, 6> J;
  J << -cross_matrix(eigen(result.X_DH.R) * eigen(p_H)), Matrix3d::Identity();
  return std::sqrt(std::max(0.0, (J * covariance * J.transpose()).trace()));
}

std::size_t most_useful_touch(Points touched_H, Points candidates_H, const Box& workspace_H) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < candidates_H.size(); ++i) {
    std::vector<dvec3> points(touched_H.begin(), touched_H.end());
    points.push_back(candidates_H[i]);
    dvec3 centroid(0);
    for (const dvec3& p : points) centroid += p / static_cast<double>(points.size());
    Indices all(points.size());
    std::iota(all.begin(), all.end(), 0u);
    const Scatter scatter = scatter_of(points, all, centroid);
    // Variances for σ = 1. A ridge keeps them finite while the rotation is not determined.
    const Matrix3d S = second_moment(workspace_H, centroid);
    const double ridge = 1e-6 * eigen(workspace_H.high - workspace_H.low).squaredNorm();
    const Vector3d variance = ((scatter.values.sum() + ridge) * Vector3d::Ones() - scatter.values).cwiseInverse();
    const Matrix3d C = scatter.axes * variance.asDiagonal() * scatter.axes.transpose();
    const double tre2 = 3.0 / static_cast<double>(points.size()) + S.trace() * C.trace() - (S * C).trace();
    if (tre2 < least) least = tre2, best = i;
  }
  return best;
}

}  // namespace typodont::calibration
