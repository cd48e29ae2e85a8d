#include "calibration/solver/near_rival.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/solver/agreement.h"
#include "calibration/solver/eigen_math.h"
namespace typodont::calibration {

namespace {

constexpr std::size_t kMin = 3;        // smallest number of pairs that determine a motion
constexpr std::size_t kSearched = 64;  // largest number of pairs in the coarse search

// Two motions from H to D, and the pairs that follow each.
struct Halves {
  Pose X[2];
  Indices pairs[2];
  double sse = std::numeric_limits<double>::infinity();
};

class Splitter {
 public:
  Splitter(Points p_H, Points p_D) : p_H_(p_H), p_D_(p_D) {}

  double residual2(const Pose& X, std::size_t i) const {
    const dvec3 r = X * p_H_[i] - p_D_[i];
    return glm::dot(r, r);
  }

  Pose fit(const Indices& pairs) const {
    h_.clear(), d_.clear();
    for (const std::size_t i : pairs) h_.push_back(p_H_[i]), d_.push_back(p_D_[i]);
    return fit_rigid(h_, d_);
  }

  /// Assigns pairs to the nearer motion and refits, until nothing changes. Returns false if a motion keeps too few
  /// pairs.
  bool settle(std::span<const std::size_t> pairs, Halves& halves, int rounds) const {
    Indices next[2];
    for (int round = 0; round < rounds; ++round) {
      const glm::dmat3 R[2] = {glm::mat3_cast(halves.X[0].R), glm::mat3_cast(halves.X[1].R)};
      next[0].clear(), next[1].clear();
      double sse = 0;
      for (const std::size_t i : pairs) {
        const dvec3 r0 = R[0] * p_H_[i] + halves.X[0].p - p_D_[i], r1 = R[1] * p_H_[i] + halves.X[1].p - p_D_[i];
        const double a = glm::dot(r0, r0), b = glm::dot(r1, r1);
        next[b < a ? 1 : 0].push_back(i);
        sse += std::min(a, b);
      }
      if (next[0].size() < kMin || next[1].size() < kMin) return false;
      const bool same = next[0] == halves.pairs[0];
      for (int side = 0; side < 2; ++side) {
        halves.pairs[side].swap(next[side]);
        if (!same) halves.X[side] = fit(halves.pairs[side]);
      }
      halves.sse = sse;
      if (same) break;
    }
    return true;
  }

 private:
  Points p_H_, p_D_;
  mutable std::vector<dvec3> h_, d_;
};

double log_choose(std::size_t n, std::size_t k) {
  return std::lgamma(static_cast<double>(n) + 1) - std::lgamma(static_cast<double>(k) + 1) -
         std::lgamma(static_cast<double>(n - k) + 1);
}

}  // namespace

std::optional<Split> split_in_two(Points p_H, Points p_D, std::span<const std::size_t> pairs, double known_sigma,
                                  double rounding) {
  const std::size_t m = pairs.size();
  if (m < 2 * kMin) return std::nullopt;
  const Splitter splitter(p_H, p_D);
  const Indices everyone(pairs.begin(), pairs.end());

  // Fits one motion, and computes the scatter of its residuals.
  const Pose X = splitter.fit(everyone);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const std::size_t i : pairs) {
    const Eigen::Vector3d e = eigen(X * p_H[i] - p_D[i]);
    scatter += e * e.transpose();
  }
  const double sse = scatter.trace();
  const double floor2 = rounding * rounding;
  if (sse <= static_cast<double>(m) * floor2) return std::nullopt;

  Indices looked_at;
  const std::size_t step = (m + kSearched - 1) / kSearched;
  for (std::size_t k = 0; k < m; k += step) looked_at.push_back(everyone[k]);
  const std::size_t n = looked_at.size();

  Halves best;
  // The second motion is fitted to the half of `looked_at` that `first` fits worst.
  std::vector<std::pair<double, std::size_t>> order(n);
  const auto start_from = [&](const Pose& first) {
    for (std::size_t k = 0; k < n; ++k) order[k] = {splitter.residual2(first, looked_at[k]), looked_at[k]};
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(n / 2), order.end());
    Indices far;
    for (std::size_t k = n / 2; k < n; ++k) far.push_back(order[k].second);
    Halves halves{{first, splitter.fit(far)}, {}};
    if (splitter.settle(looked_at, halves, 12) && halves.sse < best.sse) best = halves;
  };
  // For two motions that differ by a displacement: splits by the residual's sign along the residuals' main direction.
  const auto axes = eigen_of(scatter);
  const dvec3 longest = vec(axes.eigenvectors().col(2));
  Indices up;
  for (const std::size_t i : looked_at) {
    if (glm::dot(X * p_H[i] - p_D[i], longest) > 0) up.push_back(i);
  }
  if (up.size() >= kMin) start_from(splitter.fit(up));
  // If both motions have equally many pairs, one triple in four has a single motion. Tries all triples, or 48 random.
  const auto triple = [&](std::size_t a, std::size_t b, std::size_t c) {
    start_from(splitter.fit({looked_at[a], looked_at[b], looked_at[c]}));
  };
  if (n <= 8) {
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = a + 1; b < n; ++b) {
        for (std::size_t c = b + 1; c < n; ++c) triple(a, b, c);
      }
    }
  } else {
    SplitMix64 random{1};
    const auto draw = [&] { return random_index(random, n); };
    for (int k = 0; k < 48; ++k) {
      const std::size_t a = draw(), b = draw(), c = draw();
      if (a != b && b != c && a != c) triple(a, b, c);
    }
  }
  if (best.pairs[0].empty() || !splitter.settle(pairs, best, 30)) return std::nullopt;

  // Probability of such a split by chance × number of possible splits. For m pairs, Σ residual² of two motions / Σ of
  // one motion has the distribution Beta(1.5m-6, 3). With known σ, the decrease of Σ / σ² is chi-squared (6 degrees).
  Split split;
  const double freedom = 3 * static_cast<double>(m) - 12;
  const double left = std::max(best.sse, std::max(freedom, 1.0) * floor2);
  const double splits = log_choose(m, best.pairs[0].size());
  if (known_sigma > 0) {
    const double half = 0.5 * (sse - left) / (known_sigma * known_sigma);
    split.log_nfa = splits - half + std::log1p(half + 0.5 * half * half);
    split.sigma = known_sigma;
  } else {
    if (freedom < 3) return std::nullopt;
    const double x = std::min(1.0, left / sse), y = 1 - x, a = 0.5 * freedom;
    split.log_nfa = splits + a * std::log(x) + std::log1p(a * y + 0.5 * a * (a + 1) * y * y);
    split.sigma = std::sqrt(left / freedom);
    // Noise that is larger along one axis looks like two motions. A split must be more likely than such noise.
    const auto count = static_cast<double>(m);
    const double thinnest = floor2;
    double log_det = 0;
    for (int axis = 0; axis < 3; ++axis) log_det += std::log(std::max(axes.eigenvalues()[axis] / count, thinnest));
    if (-1.5 * count * std::log(left / (3 * count)) - splits < 2 - 0.5 * count * log_det) return std::nullopt;
  }
  const int larger = best.pairs[0].size() >= best.pairs[1].size() ? 0 : 1;
  split.X_first = best.X[larger], split.X_second = best.X[1 - larger];
  split.first = std::move(best.pairs[larger]), split.second = std::move(best.pairs[1 - larger]);
  return split;
}

double assign_to_nearer(Points p_H, Points p_D, double limit, Split& split) {
  const Splitter splitter(p_H, p_D);
  const double limit2 = limit * limit;
  for (int round = 0; round < 20; ++round) {
    Indices first, second;
    for (std::size_t i = 0; i < p_H.size(); ++i) {
      const double a = splitter.residual2(split.X_first, i), b = splitter.residual2(split.X_second, i);
      if (std::min(a, b) > limit2) continue;
      (a <= b ? first : second).push_back(i);
    }
    if (first.size() < kMin || second.size() < kMin) break;
    const bool same = first == split.first && second == split.second;
    split.first = std::move(first), split.second = std::move(second);
    if (same) break;
    split.X_first = splitter.fit(split.first), split.X_second = splitter.fit(split.second);
  }
  if (split.first.size() < split.second.size()) {
    std::swap(split.first, split.second);
    std::swap(split.X_first, split.X_second);
  }
  double expected = 0;
  for (const Indices* side : {&split.first, &split.second}) {
    for (const std::size_t i : *side) {
      const double apart = glm::length(split.X_first * p_H[i] - split.X_second * p_H[i]);
      expected += 0.5 * std::erfc(0.5 * apart / (std::sqrt(2.0) * std::max(split.sigma, 1e-300)));
    }
  }
  return expected;
}

}  // namespace typodont::calibration
