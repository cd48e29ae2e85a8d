#include "calibration/registration_solver.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "calibration/solver/near_rival.h"
#include "calibration/statistics.h"
#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::calibration {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Points = std::span<const dvec3>;
using Indices = std::vector<std::size_t>;

constexpr double kUndetermined = 1e16;  // a condition beyond what doubles can tell
constexpr double kUniformAngleVariance = kPi * kPi / 3;

Vector3d eigen(const dvec3& v) {
  return {v.x, v.y, v.z};
}
dvec3 vec(const Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
Matrix3d eigen(const dquat& q) {
  return Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
}
Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

double largest_coordinate(Points a, Points b) {
  double largest = 0;
  for (const Points points : {a, b}) {
    for (const dvec3& p : points) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  }
  return largest;
}

// The size of the place the points fill, as the edge of a cube; flat sets count as the cube they could have filled.
double extent(Points points) {
  dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
  for (const dvec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
  const dvec3 size = high - low;
  return std::max({size.x, size.y, size.z});
}

struct Fit {
  Pose X_DH;
  Indices pairs;
  double sse = 0;
};

Fit fit_to(Points p_H, Points p_D, Indices pairs) {
  std::vector<dvec3> h, d;
  for (const std::size_t i : pairs) h.push_back(p_H[i]), d.push_back(p_D[i]);
  Fit fit{fit_rigid(h, d), std::move(pairs), 0};
  for (std::size_t i = 0; i < h.size(); ++i) {
    const dvec3 r = fit.X_DH * h[i] - d[i];
    fit.sse += glm::dot(r, r);
  }
  return fit;
}

std::size_t followers(Points p_H, Points p_D, const Pose& X_DH, double limit) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < p_H.size(); ++i) count += glm::length(X_DH * p_H[i] - p_D[i]) <= limit;
  return count;
}

// Robust consensus without a known noise level, after Moisan & Stival 2004 (a contrario RANSAC): the number of false
// alarms NFA(k) = tests · C(n,k) · C(k,3) · α_k^(k-3), α_k = chance that a stray point falls within the k-th residual.
class Consensus {
 public:
  /// A normal cloud of `sigma` in which stray points fall; nothing: the cube around all points. Inside a cloud nothing
  /// counts as tighter than a thirtieth of it: a few pairs that coincide to the last digit are an instrument's steps.
  Consensus(Points p_H, Points p_D, double false_alarm, double sigma = 0)
      : p_H_(p_H),
        p_D_(p_D),
        n_(p_H.size()),
        false_alarm_(false_alarm),
        floor_(std::max(64 * std::numeric_limits<double>::epsilon() * largest_coordinate(p_H, p_D), sigma / 30)),
        // A normal cloud is nowhere denser than at its middle.
        log_volume_(sigma > 0 ? 1.5 * std::log(2 * kPi) + 3 * std::log(sigma)
                              : 3 * std::log(std::max({extent(p_H), extent(p_D), floor_, 1e-300}))),
        log_choose_(n_ + 1) {
    const double octaves = std::log2(std::max(floor_ * floor_, 1e-300));
    first_bin_ = bin_of_bits(std::exp2(std::floor(octaves)));
    for (std::size_t b = 0; b < kBins; ++b) {
      // The upper edge of bin b: the next power of two, in quarters.
      const double edge =
          std::exp2(std::floor(octaves) + static_cast<double>(b / 4)) * (1 + static_cast<double>(b % 4 + 1) / 4);
      log_alpha_[b] = log_alpha(edge);
    }
    for (std::size_t k = 0; k <= n_; ++k) {
      const auto n = static_cast<double>(n_), kd = static_cast<double>(k);
      log_choose_[k] = std::lgamma(n + 1) - std::lgamma(kd + 1) - std::lgamma(n - kd + 1) +
                       (k >= 3 ? std::log(kd * (kd - 1) * (kd - 2) / 6) : 0.0);
    }
  }

  struct Best {
    Fit fit;
    double log_nfa = std::numeric_limits<double>::infinity();
  };

  /// The tightest consensus there is. Wrong touches near their true places also agree, loosely; so look inside what was
  /// found for a core far tighter than chance would put into a normal cloud of its size, and start again from that.
  Best find() const {
    Best best = find_widest();
    while (best.log_nfa < 0 && best.fit.pairs.size() >= 5) {
      const double sigma = sigma_of(best.fit);
      if (sigma <= floor_) break;
      std::vector<dvec3> h, d;
      for (const std::size_t i : best.fit.pairs) h.push_back(p_H_[i]), d.push_back(p_D_[i]);
      const Best core = Consensus(h, d, false_alarm_, sigma).find_widest();
      if (core.log_nfa > 0) break;
      Indices pairs;
      for (const std::size_t i : core.fit.pairs) pairs.push_back(best.fit.pairs[i]);
      const Fit fit = grow(fit_to(p_H_, p_D_, std::move(pairs)));
      if (fit.pairs.size() < 4 || sigma_of(fit) > 0.7 * sigma) break;
      best = {fit, nfa_of(fit)};
    }
    return best;
  }

  double sigma_of(const Fit& fit) const { return std::sqrt(fit.sse / (3 * static_cast<double>(fit.pairs.size()) - 6)); }

 private:
  Best find_widest() const {
    std::vector<Candidate> top;
    std::vector<double> r2(n_);
    for_each_triple([&](std::size_t i, std::size_t j, std::size_t k) {
      const dvec3 h[3] = {p_H_[i], p_H_[j], p_H_[k]}, d[3] = {p_D_[i], p_D_[j], p_D_[k]};
      Candidate candidate{fit_rigid(h, d), 0, 0};
      residuals(candidate.X_DH, r2);
      std::tie(candidate.log_nfa, candidate.count) = best_nfa(r2);
      keep(top, candidate);
      return static_cast<double>(top.front().count) / static_cast<double>(n_);
    });
    Best best;
    for (const Candidate& candidate : top) {
      const Fit fit = grow(candidate);
      const double nfa = nfa_of(fit);
      if (nfa < best.log_nfa) best = {fit, nfa};
    }
    return best;
  }

  struct Candidate {
    Pose X_DH;
    double log_nfa;
    std::size_t count;
  };

  template <class F>
  void for_each_triple(F visit) const {
    if (n_ <= 20) {  // at most 1140: all of them
      for (std::size_t i = 0; i < n_; ++i) {
        for (std::size_t j = i + 1; j < n_; ++j) {
          for (std::size_t k = j + 1; k < n_; ++k) (void)visit(i, j, k);
        }
      }
      return;
    }
    // With 30 % good pairs one triple in 37 is good: 1500 miss all with probability 1e-18. Once many agree, fewer will
    // do: 1e-9 of missing a better triple of that share.
    Noise random(1);
    double needed = 1500;
    for (int draw = 0; draw < needed; ++draw) {
      const std::size_t i = random.index(n_), j = random.index(n_), k = random.index(n_);
      if (i == j || j == k || i == k) continue;
      const double share = visit(i, j, k);
      needed = std::clamp(std::log(1e-9) / std::log1p(-std::min(0.99, share * share * share)), 100.0, 1500.0);
    }
  }

  void residuals(const Pose& X_DH, std::vector<double>& r2) const {
    const glm::dmat3 R = glm::mat3_cast(X_DH.R);
    for (std::size_t i = 0; i < n_; ++i) {
      const dvec3 r = R * p_H_[i] + X_DH.p - p_D_[i];
      r2[i] = glm::dot(r, r);
    }
  }

  double log_alpha(double r2) const {
    return std::min(0.0, std::log(4 * kPi / 3) + 1.5 * std::log(std::max(r2, floor_ * floor_)) - log_volume_);
  }
  double log_nfa(double log_alpha_k, std::size_t k) const {
    return std::log(static_cast<double>(n_)) + log_choose_[k] + static_cast<double>(k - 3) * log_alpha_k;
  }

  // Four bins an octave, straight from the bits of the number: sorting would take most of the time.
  static std::int64_t bin_of_bits(double x) { return static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(x) >> 50); }

  std::pair<double, std::size_t> best_nfa(const std::vector<double>& r2) const {
    std::array<std::uint32_t, kBins> counts{};
    std::size_t low = kBins, high = 0;
    for (const double r : r2) {
      const auto bin = static_cast<std::size_t>(std::clamp<std::int64_t>(bin_of_bits(r) - first_bin_, 0, kBins - 1));
      ++counts[bin];
      low = std::min(low, bin), high = std::max(high, bin);
    }
    std::pair<double, std::size_t> best{std::numeric_limits<double>::infinity(), 0};
    std::size_t k = 0;
    for (std::size_t b = low; b <= high; ++b) {
      k += counts[b];
      if (counts[b] > 0 && k >= 4) best = std::min(best, {log_nfa(log_alpha_[b], k), k});
    }
    return best;
  }

  double nfa_of(const Fit& fit) const {
    if (fit.pairs.size() < 4) return std::numeric_limits<double>::infinity();
    std::vector<double> r2(n_);
    residuals(fit.X_DH, r2);
    double worst = 0;
    for (const std::size_t i : fit.pairs) worst = std::max(worst, r2[i]);
    return log_nfa(log_alpha(worst), fit.pairs.size());
  }

  static void keep(std::vector<Candidate>& top, const Candidate& candidate) {
    constexpr std::size_t kKept = 8;
    if (top.size() == kKept && candidate.log_nfa >= top.back().log_nfa) return;
    const auto place = std::upper_bound(top.begin(), top.end(), candidate,
                                        [](const auto& a, const auto& b) { return a.log_nfa < b.log_nfa; });
    top.insert(place, candidate);
    if (top.size() > kKept) top.pop_back();
  }

  Fit grow(const Candidate& candidate) const {
    std::vector<double> r2(n_);
    residuals(candidate.X_DH, r2);
    Indices order(n_);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return r2[a] < r2[b]; });
    order.resize(candidate.count);
    std::sort(order.begin(), order.end());
    return grow(fit_to(p_H_, p_D_, order));
  }

  // Refits and takes in everything within the noise of the fit, until nothing changes. Starting from too few, the
  // threshold widens by itself: a ball of radius tσ cut out of a normal cloud has an rms of at least tσ/√5.
  Fit grow(Fit fit) const {
    std::vector<double> r2(n_);
    for (int round = 0; round < 60; ++round) {
      const auto k = static_cast<double>(fit.pairs.size());
      if (fit.pairs.size() < 4) break;
      const double dof = 3 * k - 6;
      const double variance = std::max(fit.sse / dof, floor_ * floor_);
      auto& quantile = quantiles_[fit.pairs.size()];
      if (quantile == 0) quantile = f_quantile(1 - false_alarm_ / static_cast<double>(n_), 3, dof);
      const double limit = 3 * variance * quantile;
      residuals(fit.X_DH, r2);
      Indices inside;
      for (std::size_t i = 0; i < n_; ++i) {
        if (r2[i] <= limit) inside.push_back(i);
      }
      if (inside == fit.pairs || inside.size() < 4) break;
      fit = fit_to(p_H_, p_D_, std::move(inside));
    }
    return fit;
  }

  Points p_H_, p_D_;
  std::size_t n_;
  double false_alarm_;
  double floor_;
  double log_volume_;
  std::vector<double> log_choose_;
  static constexpr std::size_t kBins = 512;
  std::int64_t first_bin_ = 0;
  std::array<double, kBins> log_alpha_{};
  mutable std::map<std::size_t, double> quantiles_;
};

// Where the noise of a touch is known, "within the noise" is a number, and a hypothesis is judged by counting: random
// triples whose edges have the same length on both sides, each refitted to all that agrees before it is counted (Chum,
// Matas & Kittler 2003), until a larger set is missed with a chance of 1e-9 only.
class KnownNoise {
 public:
  KnownNoise(Points p_H, Points p_D, double sigma, double false_alarm)
      : p_H_(p_H), p_D_(p_D), n_(p_H.size()), edge_(5 * std::sqrt(2.0) * sigma) {
    const double floor = 64 * std::numeric_limits<double>::epsilon() * largest_coordinate(p_H, p_D);
    limit2_ =
        std::max(sigma * sigma * chi_squared_quantile(1 - false_alarm / static_cast<double>(n_), 3), floor * floor);
    edge_ = std::max(edge_, 2 * floor);
  }

  struct Best {
    Fit fit;
    double log_nfa = std::numeric_limits<double>::infinity();
  };

  /// `all` is the fit to every pair. Sets smaller than `least` are of no interest.
  Best find(const Fit& all, std::size_t least) const {
    Best best{grow(all, 0), 0};
    // Four good pairs of sixteen are missed with a chance of 1e-9; of a few pairs every triple soon had its turn.
    const double most = std::min(3000.0, 4 * std::pow(static_cast<double>(n_), 3));
    double needed = needed_for(std::max(least, best.fit.pairs.size()));
    std::uint64_t state = 1;
    std::vector<bool> agrees(n_);
    const auto mark = [&] {
      agrees.assign(n_, false);
      for (const std::size_t i : best.fit.pairs) agrees[i] = true;
    };
    mark();
    for (double draw = 0; draw < std::min(needed, most); ++draw) {
      const std::size_t i = random_index(state), j = random_index(state), k = random_index(state);
      if (i == j || j == k || i == k || !same_length(i, j) || !same_length(j, k) || !same_length(i, k)) continue;
      if (agrees[i] && agrees[j] && agrees[k]) continue;  // would find the same again
      const dvec3 h[3] = {p_H_[i], p_H_[j], p_H_[k]}, d[3] = {p_D_[i], p_D_[j], p_D_[k]};
      const std::size_t have = best.fit.pairs.size();
      const Fit fit = grow({fit_rigid(h, d), {}, 0}, have / 2);
      const std::size_t found = fit.pairs.size();
      if (found < have || (found == have && fit.sse >= best.fit.sse)) continue;
      best.fit = fit;
      mark();
      needed = needed_for(std::max(least, found));
    }
    // The chance that stray pairs agree so well, as Consensus has it.
    const auto n = static_cast<double>(n_), k = static_cast<double>(best.fit.pairs.size());
    if (k < 4) return {std::move(best.fit)};
    const double edge = std::max({extent(p_H_), extent(p_D_), 1e-300});
    const double log_alpha = std::min(0.0, std::log(4 * kPi / 3) + 1.5 * std::log(limit2_) - 3 * std::log(edge));
    best.log_nfa = std::log(n) + std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) +
                   std::log(k * (k - 1) * (k - 2) / 6) + (k - 3) * log_alpha;
    return best;
  }

 private:
  // SplitMix64: the generators of the library take longer to seed than all of this takes to run.
  std::size_t random_index(std::uint64_t& state) const {
    std::uint64_t z = (state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return static_cast<std::size_t>((z >> 32) * n_ >> 32);
  }

  bool same_length(std::size_t i, std::size_t j) const {
    return std::abs(glm::length(p_H_[i] - p_H_[j]) - glm::length(p_D_[i] - p_D_[j])) <= edge_;
  }

  double needed_for(std::size_t count) const {
    const auto n = static_cast<double>(n_), k = static_cast<double>(count);
    if (count == n_) return 0;
    return std::log(1e-9) / std::log1p(-std::min(0.99, k * (k - 1) * (k - 2) / (n * (n - 1) * (n - 2))));
  }

  // Refits to whatever agrees until that stays the same. Not worth it where fewer than `least` agree at first.
  Fit grow(Fit fit, std::size_t least) const {
    for (int round = 0; round < 20; ++round) {
      const glm::dmat3 R = glm::mat3_cast(fit.X_DH.R);
      Indices inside;
      inside.reserve(n_);
      for (std::size_t i = 0; i < n_; ++i) {
        const dvec3 r = R * p_H_[i] + fit.X_DH.p - p_D_[i];
        if (glm::dot(r, r) <= limit2_) inside.push_back(i);
      }
      if (inside == fit.pairs) break;
      if (inside.size() < std::max<std::size_t>(3, round == 0 ? least : 0)) {
        fit.pairs.clear();
        break;
      }
      fit = fit_to(p_H_, p_D_, std::move(inside));
    }
    return fit;
  }

  Points p_H_, p_D_;
  std::size_t n_;
  double edge_, limit2_ = 0;
};

/// The largest set of pairs that agree, with the logarithm of how often chance alone brings as many together.
/// Where the noise is known, sets smaller than `least` need not be found.
std::pair<Fit, double> largest_agreement(Points p_H, Points p_D, const RegistrationOptions& options,
                                         std::size_t least) {
  if (options.known_sigma > 0) {
    Indices everyone(p_H.size());
    std::iota(everyone.begin(), everyone.end(), 0u);
    auto best = KnownNoise(p_H, p_D, options.known_sigma, options.false_alarm)
                    .find(fit_to(p_H, p_D, std::move(everyone)), least);
    return {std::move(best.fit), best.log_nfa};
  }
  auto best = Consensus(p_H, p_D, options.false_alarm).find();
  return {std::move(best.fit), best.log_nfa};
}

struct Scatter {
  Vector3d values;  // ascending: sums of squares along each principal axis
  Matrix3d axes;    // columns, in H
};

Scatter scatter_of(Points p_H, const Indices& pairs, const dvec3& centroid) {
  Matrix3d sum = Matrix3d::Zero();
  for (const std::size_t i : pairs) {
    const Vector3d h = eigen(p_H[i] - centroid);
    sum += h * h.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(sum);
  Scatter scatter{solver.eigenvalues().cwiseMax(0), solver.eigenvectors()};
  // Eigenvalues far below the largest are lost in its rounding; measured across the axes they are not.
  scatter.values.head<2>().setZero();
  for (const std::size_t i : pairs) {
    const Vector3d across = scatter.axes.transpose() * eigen(p_H[i] - centroid);
    scatter.values[0] += across[0] * across[0];
    scatter.values[1] += across[1] * across[1];
  }
  return scatter;
}

std::string words(const dvec3& v) {
  return fmt::format("({:.3f}, {:.3f}, {:.3f})", v.x, v.y, v.z);
}

// Pairs that a mirrored fit explains far better than a rigid one (F-test at 1 %; flat sets fit both ways alike).
bool mirrored(Points p_H, Points p_D, const Fit& fit, double rounding) {
  const double dof = 3 * static_cast<double>(fit.pairs.size()) - 6;
  if (dof < 6) return false;
  std::vector<dvec3> h, inverted;
  for (const std::size_t i : fit.pairs) h.push_back(p_H[i]), inverted.push_back(-p_D[i]);
  const Pose X = fit_rigid(h, inverted);
  double sse = dof * rounding * rounding;
  for (std::size_t i = 0; i < h.size(); ++i) {
    const dvec3 r = X * h[i] - inverted[i];
    sse += glm::dot(r, r);
  }
  return fit.sse > sse && fit.sse > sse * f_quantile(0.99, dof, dof);
}

// Lengths in D over lengths in H, where a rigid fit with a scale explains the pairs far better and the scale is 2 %
// off.
std::optional<double> other_scale(Points p_H, Points p_D, const Fit& fit, double rounding) {
  const double dof = 3 * static_cast<double>(fit.pairs.size()) - 7;
  if (dof < 2) return std::nullopt;
  dvec3 c_H(0), c_D(0);
  for (const std::size_t i : fit.pairs) c_H += p_H[i], c_D += p_D[i];
  c_H /= static_cast<double>(fit.pairs.size()), c_D /= static_cast<double>(fit.pairs.size());
  double hh = 0, hd = 0;  // the best rotation does not depend on the scale (Umeyama 1991)
  for (const std::size_t i : fit.pairs) {
    const dvec3 h = p_H[i] - c_H;
    hh += glm::dot(h, h), hd += glm::dot(fit.X_DH.rotate(h), p_D[i] - c_D);
  }
  if (!(hh > 0)) return std::nullopt;
  const double scale = hd / hh, gained = (scale - 1) * (scale - 1) * hh;
  const double sse = std::max(fit.sse - gained, dof * rounding * rounding);
  if (std::abs(scale - 1) < 0.02 || gained < sse / dof * f_quantile(1 - 1e-4, 1, dof)) return std::nullopt;
  return scale;
}

// A mirror image becomes a rigid motion when D is turned inside out, p_D -> -p_D.
bool mirror_fits_better(Points p_H, Points p_D, const Fit& fit, const RegistrationOptions& options) {
  if (p_H.size() < 4) return false;
  std::vector<dvec3> inverted(p_D.size());
  std::transform(p_D.begin(), p_D.end(), inverted.begin(), [](const dvec3& p) { return -p; });
  const Fit mirrored = largest_agreement(p_H, inverted, options, 5 * fit.pairs.size() / 4).first;
  if (mirrored.pairs.size() < std::max<std::size_t>(4, p_H.size() / 4)) return false;
  // Flat sets are their own mirror images: both fit alike. Where the set is not flat, the true one is tighter and
  // larger.
  const double floor2 = std::pow(64 * std::numeric_limits<double>::epsilon() * largest_coordinate(p_H, p_D), 2);
  const auto variance = [&](const Fit& f) {
    return std::max(f.sse / std::max(1.0, 3 * static_cast<double>(f.pairs.size()) - 6), floor2);
  };
  const double ratio = variance(mirrored) / variance(fit);
  return (ratio < 4 && 4 * mirrored.pairs.size() > 5 * fit.pairs.size()) ||
         (ratio < 0.1 && mirrored.pairs.size() >= fit.pairs.size());
}

}  // namespace

const char* name(Defect defect) {
  switch (defect) {
    case Defect::kNone:
      return "none";
    case Defect::kCoincident:
      return "coincident";
    case Defect::kCollinear:
      return "collinear";
    case Defect::kNoise:
      return "noise";
    case Defect::kMirrored:
      return "mirrored";
    case Defect::kScaled:
      return "scaled";
    case Defect::kNoConsensus:
      return "no_consensus";
  }
  return "none";
}

RegistrationResult register_points(Points p_H, Points p_D, const RegistrationOptions& options) {
  const std::size_t n = p_H.size();
  if (n == 0) throw Error("registration: found no pair, expected at least one");
  if (n != p_D.size()) {
    throw Error(fmt::format("registration: found {} points in H and {} in D, expected as many", n, p_D.size()));
  }
  RegistrationResult result;
  const double rounding = 64 * std::numeric_limits<double>::epsilon() * largest_coordinate(p_H, p_D);

  // Who agrees with whom.
  Indices everyone(n);
  std::iota(everyone.begin(), everyone.end(), 0u);
  Fit fit;
  bool consensus = true;
  fit = fit_to(p_H, p_D, everyone);
  const bool exact = fit.sse <= static_cast<double>(n) * rounding * rounding;
  if (options.reject_outliers && n >= 4 && !exact) {
    auto [best, log_nfa] = largest_agreement(p_H, p_D, options, 3);
    consensus = log_nfa < 0;
    if (consensus) fit = std::move(best);
  }
  const auto spare = [](const Fit& f) { return std::sqrt(f.sse / (3 * static_cast<double>(f.pairs.size()) - 6)); };
  // How far from its place a good pair may lie.
  const auto reach = [&](double sigma, double dof) {
    const double p = 1 - options.false_alarm / static_cast<double>(n);
    return std::max(
        rounding, options.known_sigma > 0 ? options.known_sigma * std::sqrt(chi_squared_quantile(p, 3))
                                          : sigma * std::sqrt(3 * f_quantile(p, 3, std::max(1.0, dof))));
  };
  // Gives every pair to the nearer motion. A second one that many pairs would follow (those that follow both count too),
  // or so near that some may have gone to the wrong one, is a rival; otherwise its pairs are outliers.
  const auto part = [&](Split& split, double dof) {
    const double limit = reach(split.sigma, dof);
    const double doubtful = share_out(p_H, p_D, limit, split);
    fit = fit_to(p_H, p_D, split.first);
    if (10 * followers(p_H, p_D, split.X_second, limit) < 3 * split.first.size() && doubtful < 0.02) return false;
    result.rivals.push_back({split.X_second, split.second});
    return true;
  };
  const auto outliers_of = [&](const Fit& f) {
    Indices rest;
    std::set_difference(everyone.begin(), everyone.end(), f.pairs.begin(), f.pairs.end(), std::back_inserter(rest));
    return rest;
  };

  // One motion, or two that nearly coincide? Told the noise, only where the residuals do not look like it (5 %).
  bool too_noisy = false;
  for (int round = 0; options.reject_outliers && consensus && !exact && round < 3; ++round) {
    const double dof = 3 * static_cast<double>(fit.pairs.size()) - 6;
    if (options.known_sigma > 0) {
      const double excess = 1 - chi_squared_cdf(fit.sse / (options.known_sigma * options.known_sigma), std::max(1.0, dof));
      too_noisy = excess < 1e-4;
      if (excess > 0.05) break;
    }
    auto split = split_in_two(p_H, p_D, fit.pairs, options.known_sigma, rounding);
    if (!split || split->log_nfa > std::log(1e-3) || part(*split, dof - 6)) break;
  }

  // Others who agree on something else.
  if (consensus && result.rivals.empty()) {
    Indices rest = outliers_of(fit);
    while (rest.size() >= 4) {
      std::vector<dvec3> h, d;
      for (const std::size_t i : rest) h.push_back(p_H[i]), d.push_back(p_D[i]);
      // Told the noise, four pairs that agree are an argument.
      const double chance = options.known_sigma > 0 ? 1e-3 : 1e-4;
      const auto [rival, log_nfa] = largest_agreement(h, d, options, 3 * fit.pairs.size() / 10);
      // A loose agreement is wrong touches near their true places, not a second motion.
      if (log_nfa > std::log(chance) || spare(rival) > 4 * std::max(spare(fit), rounding)) break;
      Indices pairs, left;
      for (const std::size_t i : rival.pairs) pairs.push_back(rest[i]);
      std::set_difference(rest.begin(), rest.end(), pairs.begin(), pairs.end(), std::back_inserter(left));
      Split split{fit.X_DH, rival.X_DH, fit.pairs, pairs, std::max(spare(fit), rounding), log_nfa};
      part(split, 3 * static_cast<double>(fit.pairs.size()) - 6);
      rest = std::move(left);
    }
  }

  result.X_DH = fit.X_DH;
  result.inliers = fit.pairs;
  result.outliers = outliers_of(fit);
  for (std::size_t i = 0; i < n; ++i) result.residuals.push_back(glm::length(fit.X_DH * p_H[i] - p_D[i]));

  // Three outliers that agree are too few to stand up against chance alone, but they agree within the noise that the
  // others have, and where three in ten would follow their motion that is enough for doubt.
  if (consensus && result.rivals.empty() && result.outliers.size() >= 3 && result.outliers.size() <= 12 &&
      fit.pairs.size() >= 4) {
    const double dof = 3 * static_cast<double>(fit.pairs.size()) - 6, sigma = std::max(spare(fit), rounding);
    double least = options.known_sigma > 0 ? options.known_sigma * options.known_sigma * chi_squared_quantile(0.999, 3)
                                           : sigma * sigma * 3 * f_quantile(0.999, 3, dof);
    const double limit = reach(sigma, dof);
    const Indices& rest = result.outliers;
    for (std::size_t a = 0; a < rest.size(); ++a) {
      for (std::size_t b = a + 1; b < rest.size(); ++b) {
        for (std::size_t c = b + 1; c < rest.size(); ++c) {
          const Fit rival = fit_to(p_H, p_D, {rest[a], rest[b], rest[c]});
          if (rival.sse > least || 10 * followers(p_H, p_D, rival.X_DH, limit) < 3 * fit.pairs.size()) continue;
          least = rival.sse;
          result.rivals.assign(1, {rival.X_DH, rival.pairs});
        }
      }
    }
  }

  // Noise, from what the fit leaves over.
  const auto k = static_cast<double>(fit.pairs.size());
  for (const std::size_t i : fit.pairs) result.centroid_H += p_H[i] / k;
  const Scatter scatter = scatter_of(p_H, fit.pairs, result.centroid_H);
  const Vector3d spread = (scatter.values / k).cwiseSqrt();  // rms along the principal axes, ascending
  const bool coincident_exactly = spread[2] <= 4 * rounding;
  const bool collinear_exactly = spread[1] <= std::max(4 * rounding, 1e-9 * spread[2]);
  const int rotations = coincident_exactly ? 0 : collinear_exactly ? 2 : 3;
  result.degrees_of_freedom = static_cast<int>(3 * fit.pairs.size()) - 3 - rotations;
  result.fre_rms = std::sqrt(fit.sse / k);
  const double dof = result.degrees_of_freedom;
  result.sigma = options.known_sigma > 0 ? options.known_sigma
                 : dof > 0               ? std::sqrt(fit.sse / dof)
                                         : std::numeric_limits<double>::quiet_NaN();
  // With few degrees of freedom the residuals can be small by luck; judge by the noise they do not exclude (95 %).
  double noise = rounding;
  if (options.known_sigma > 0)
    noise = std::max(noise, options.known_sigma);
  else if (dof > 0)
    noise = std::max(noise, std::sqrt(fit.sse / chi_squared_quantile(0.05, dof)));

  // What the points cannot determine.
  const dvec3 line = vec(scatter.axes.col(2));
  Degeneracy& degeneracy = result.degeneracy;
  int undetermined = 0;
  if (!consensus && !collinear_exactly) {
    degeneracy.defect = Defect::kNoConsensus;
    degeneracy.reason = "no set of pairs agrees on one rigid motion better than chance";
    undetermined = 3;
  } else if (spread[2] <= std::max(4 * rounding, 4 * noise)) {
    degeneracy.defect = coincident_exactly || spread[2] <= 1.5 * noise ? Defect::kCoincident : Defect::kNoise;
    degeneracy.reason = degeneracy.defect == Defect::kCoincident
                            ? "all points lie in one place: no rotation is determined"
                            : "the residuals are as large as the spread of the points: no rotation is determined";
    undetermined = 3;
  } else if (collinear_exactly || spread[1] <= 4 * noise) {
    degeneracy.defect = collinear_exactly || spread[1] < 0.1 * spread[2] ? Defect::kCollinear : Defect::kNoise;
    degeneracy.reason =
        fmt::format("{}: the rotation about the direction {} in H is not determined",
                    degeneracy.defect == Defect::kCollinear ? "the points lie on one line"
                                                            : "the noise is as large as the spread of the points",
                    words(line));
    undetermined = 1;
  }
  if (undetermined == 3) degeneracy.undetermined_H = {dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)};
  if (undetermined == 1) degeneracy.undetermined_H = {line};

  if (too_noisy && result.rivals.empty() && degeneracy.defect == Defect::kNone) {
    degeneracy = {Defect::kNoise,
                  fmt::format("the residuals are {:.1f} times as large as the noise that was told: it is larger, or the "
                              "pairs do not all show one rigid motion",
                              std::sqrt(fit.sse / dof) / options.known_sigma),
                  {}};
  }

  // No rigid motion at all: a mirror image, or other units.
  const bool doubtful = !consensus || 5 * fit.pairs.size() < 4 * n || degeneracy.defect == Defect::kNoise ||
                        result.fre_rms > 0.1 * spread[2];
  if (doubtful && n >= 4 && mirror_fits_better(p_H, p_D, fit, options)) {
    const dvec3 thin = vec(scatter.axes.col(0));
    degeneracy = {Defect::kMirrored,
                  fmt::format("D is a mirror image of H: no rigid motion exists; one axis is reversed, such as {} in H",
                              words(thin)),
                  {thin}};
  } else if (n >= 2 && !coincident_exactly && (doubtful || n < 4)) {
    // Lengths in D over lengths in H, over pairs of points; outliers cannot move a median of up to half.
    std::vector<double> ratios;
    const std::size_t step = std::max<std::size_t>(1, n / 64);  // two thousand pairs say it as well as all
    for (std::size_t i = 0; i < n; i += step) {
      for (std::size_t j = i + step; j < n; j += step) {
        const double h = glm::length(p_H[i] - p_H[j]), d = glm::length(p_D[i] - p_D[j]);
        if (h > 10 * rounding && d > 10 * rounding) ratios.push_back(d / h);
      }
    }
    if (!ratios.empty()) {
      std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2), ratios.end());
      const double scale = ratios[ratios.size() / 2];
      std::vector<dvec3> rescaled(p_H.begin(), p_H.end());
      for (dvec3& p : rescaled) p *= scale;
      const Fit straight = fit_to(p_H, p_D, everyone), scaled = fit_to(rescaled, p_D, everyone);
      if (std::abs(std::log(scale)) > 0.1 && scaled.sse < 0.01 * straight.sse) {
        degeneracy = {
            Defect::kScaled,
            fmt::format("lengths in D are {:.4g} times those in H: no rigid motion exists; check the units", scale),
            degeneracy.undetermined_H};
      }
    }
  }

  if (degeneracy.defect == Defect::kNone && mirrored(p_H, p_D, fit, rounding)) {
    const dvec3 thin = vec(scatter.axes.col(0));
    degeneracy = {Defect::kMirrored,
                  fmt::format("D is a mirror image of H: no rigid motion exists; one axis is reversed, such as {} in H",
                              words(thin)),
                  {thin}};
  } else if (degeneracy.defect == Defect::kNone) {
    if (const auto scale = other_scale(p_H, p_D, fit, rounding)) {
      degeneracy = {
          Defect::kScaled,
          fmt::format("lengths in D are {:.4g} times those in H: no rigid motion exists; check the units", *scale),
          {}};
    }
  }

  // Covariance: Cramér–Rao, σ² (Σ(|p|² I - p pᵀ))⁻¹ for the rotation and σ²/N for the centroid, moved to the origin.
  const double sigma2 = std::isfinite(result.sigma) ? result.sigma * result.sigma : 0.0;
  const double total = scatter.values.sum();
  Vector3d variance;
  for (int axis = 0; axis < 3; ++axis) {
    const bool open = undetermined == 3 || (undetermined == 1 && axis == 2);
    const double information = total - scatter.values[axis];
    variance[axis] = open ? kUniformAngleVariance : std::min(kUniformAngleVariance, sigma2 / information);
  }
  const Matrix3d R = eigen(result.X_DH.R);
  const Matrix3d axes_D = R * scatter.axes;
  const Matrix3d C = axes_D * variance.asDiagonal() * axes_D.transpose();
  const Matrix3d lever = cross_matrix(R * eigen(result.centroid_H));
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> covariance;
  // t = c_D - R c_H, and R -> exp([θ]) R moves t by [R c_H] θ.
  covariance.topLeftCorner<3, 3>() = C;
  covariance.topRightCorner<3, 3>() = C * lever.transpose();
  covariance.bottomLeftCorner<3, 3>() = lever * C;
  covariance.bottomRightCorner<3, 3>() = lever * C * lever.transpose() + sigma2 / k * Matrix3d::Identity();
  std::copy(covariance.data(), covariance.data() + 36, result.covariance.begin());
  result.condition =
      undetermined > 0 ? kUndetermined
                       : std::min(kUndetermined, std::sqrt((total - scatter.values[0]) / (total - scatter.values[2])));

  // Mean squared TRE over the workspace: 3σ²/N + tr(S) tr(C) - tr(S C), S the second moment of the box about the
  // centroid.
  Box box = options.workspace_H;
  if (box.low == box.high) {
    box.low = box.high = p_H[fit.pairs.front()];
    for (const std::size_t i : fit.pairs) box.low = glm::min(box.low, p_H[i]), box.high = glm::max(box.high, p_H[i]);
  }
  const Vector3d size = eigen(box.high - box.low), offset = eigen(0.5 * (box.high + box.low) - result.centroid_H);
  const Matrix3d S_H = Matrix3d((size.cwiseProduct(size) / 12).asDiagonal()) + offset * offset.transpose();
  const Matrix3d S = R * S_H * R.transpose();
  result.predicted_tre_rms = std::sqrt(std::max(0.0, 3 * sigma2 / k + S.trace() * C.trace() - (S * C).trace()));
  return result;
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
    // The same formula with σ = 1; a tiny ridge lets the first touches, which determine no rotation, be compared too.
    const Vector3d size = eigen(workspace_H.high - workspace_H.low);
    const Vector3d offset = eigen(0.5 * (workspace_H.high + workspace_H.low) - centroid);
    const Matrix3d S = Matrix3d((size.cwiseProduct(size) / 12).asDiagonal()) + offset * offset.transpose();
    const double ridge = 1e-6 * size.squaredNorm();
    const Vector3d variance = ((scatter.values.sum() + ridge) * Vector3d::Ones() - scatter.values).cwiseInverse();
    const Matrix3d C = scatter.axes * variance.asDiagonal() * scatter.axes.transpose();
    const double tre2 = 3.0 / static_cast<double>(points.size()) + S.trace() * C.trace() - (S * C).trace();
    if (tre2 < least) least = tre2, best = i;
  }
  return best;
}

}  // namespace typodont::calibration
