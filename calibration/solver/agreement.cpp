#include "calibration/solver/agreement.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "calibration/statistics.h"
#include "engine/base/quantile.h"
#include "engine/base/units.h"

namespace typodont::calibration {

namespace {

// Returns the longest edge (m) of the points' bounding box.
double extent(Points points) {
  dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
  for (const dvec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
  const dvec3 size = high - low;
  return std::max({size.x, size.y, size.z});
}

// Consensus by a contrario RANSAC (Moisan & Stival 2004). NFA(k) = n · C(n,k) · C(k,3) · α_k^(k-3): expected number of
// equally good sets of k pairs by chance. α_k: probability that a wrong pair's residual is at most the k-th smallest.
class Consensus {
 public:
  /// `sigma`: wrong points are normally distributed with this standard deviation, m; 0: they are uniform in the cube
  /// around all points. Residuals below sigma/30 count as equal, because coordinates may be rounded.
  Consensus(Points p_H, Points p_D, double false_alarm, double sigma = 0)
      : p_H_(p_H),
        p_D_(p_D),
        n_(p_H.size()),
        false_alarm_(false_alarm),
        floor_(std::max(rounding_of(p_H, p_D), sigma / 30)),
        // Logarithm of the volume (m³) that contains wrong points; if sigma > 0, of 1 / their largest density.
        log_volume_(sigma > 0 ? 1.5 * std::log(2 * kPi) + 3 * std::log(sigma)
                              : 3 * std::log(std::max({extent(p_H), extent(p_D), floor_, 1e-300}))),
        log_choose_(n_ + 1) {
    const double octaves = std::log2(std::max(floor_ * floor_, 1e-300));
    first_bin_ = bin_of_bits(std::exp2(std::floor(octaves)));
    for (std::size_t b = 0; b < kBins; ++b) {
      // Upper edge of bin b; an octave has four bins.
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

  /// Finds the largest set of pairs that agree on one motion. If a core of this set agrees much better than normally
  /// distributed noise explains, uses the core; if a majority (find_majority()) has even less noise, the majority.
  Agreement find() const {
    Agreement best = find_core();
    // Noise below about 1e-9 of the coordinates is rounding error, which is not normally distributed. The search for
    // a majority with even less noise is then omitted.
    if (best.log_nfa < 0 && sigma_of(best.fit) < kArithmetic * floor_) return best;
    const Fit majority = find_majority();
    if (majority.pairs.size() >= 4 && 2 * majority.pairs.size() > n_ && sigma_of(majority) < sigma_of(best.fit)) {
      best = {majority, nfa_of(majority)};
    }
    return best;
  }

 private:
  Agreement find_core() const {
    Agreement best = find_widest();
    while (best.log_nfa < 0 && best.fit.pairs.size() >= 5) {
      const double sigma = sigma_of(best.fit);
      if (sigma <= floor_) break;
      std::vector<dvec3> h, d;
      for (const std::size_t i : best.fit.pairs) h.push_back(p_H_[i]), d.push_back(p_D_[i]);
      const Agreement core = Consensus(h, d, false_alarm_, sigma).find_widest();
      if (core.log_nfa > 0) break;
      Indices pairs;
      for (const std::size_t i : core.fit.pairs) pairs.push_back(best.fit.pairs[i]);
      const Fit fit = grow(fit_to(p_H_, p_D_, std::move(pairs)));
      if (fit.pairs.size() < 4 || sigma_of(fit) > 0.7 * sigma) break;
      best = {fit, nfa_of(fit)};
    }
    return best;
  }

  /// 1. Least trimmed squares (Rousseeuw & Van Driessen 2006) from the best triples: fit, keep the better half, repeat.
  /// 2. Forward search (Atkinson & Riani 2000): add the pairs with the smallest residuals until these exceed the noise
  /// of the set. The noise of the better half is too low, but normally distributed residuals in this half reach only
  /// 2.3 times their own standard deviation, so the search does not stop at once.
  /// 3. All pairs within the final noise.
  Fit find_majority() const {
    const std::size_t half = n_ / 2 + 1;
    if (half < 4) return {};
    std::vector<double> r2(n_);
    Indices order(n_);
    const auto nearest = [&](const Pose& X_DH, std::size_t count) {
      residuals(X_DH, r2);
      std::iota(order.begin(), order.end(), 0u);
      std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count - 1), order.end(),
                       [&](auto a, auto b) { return r2[a] < r2[b]; });
      Indices pairs(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count));
      std::sort(pairs.begin(), pairs.end());
      return pairs;
    };
    Fit best;
    best.sse = std::numeric_limits<double>::infinity();
    for (const Candidate& candidate : by_median_) {
      Fit fit = fit_to(p_H_, p_D_, nearest(candidate.X_DH, half));
      for (int step = 0; step < 30; ++step) {
        Indices next = nearest(fit.X_DH, half);
        if (next == fit.pairs) break;
        fit = fit_to(p_H_, p_D_, std::move(next));
      }
      if (fit.sse < best.sse) best = std::move(fit);
    }
    if (best.pairs.empty()) return best;
    // Probability that step 2 (forward search) stops too early; step 3 then adds the missing pairs.
    constexpr double kGrowthFalseAlarm = 0.01;
    const double surely_within = chi_squared_quantile(1 - kGrowthFalseAlarm / static_cast<double>(half), 3);
    const std::size_t step = 1 + n_ / 200;
    while (best.pairs.size() < n_) {
      const std::size_t next = std::min(n_, best.pairs.size() + step);
      // The `next` pairs with the smallest residuals; the last one in `order` has the largest of these residuals.
      Indices pairs = nearest(best.X_DH, next);
      const double dof = 3 * static_cast<double>(best.pairs.size()) - 6;
      const double variance = std::max(best.sse / dof, floor_ * floor_);
      const double farthest = r2[order[next - 1]];
      // The quantile of F is slow to compute, and never below that of chi-squared, which is compared first.
      if (farthest > variance * surely_within &&
          farthest > 3 * variance * f_quantile(1 - kGrowthFalseAlarm / static_cast<double>(next), 3, dof)) {
        break;
      }
      best = fit_to(p_H_, p_D_, std::move(pairs));
    }
    const double dof = 3 * static_cast<double>(best.pairs.size()) - 6;
    const double limit =
        3 * std::max(best.sse / dof, floor_ * floor_) * f_quantile(1 - false_alarm_ / static_cast<double>(n_), 3, dof);
    for (int round = 0; round < 20; ++round) {
      residuals(best.X_DH, r2);
      Indices inside;
      for (std::size_t i = 0; i < n_; ++i) {
        if (r2[i] <= limit) inside.push_back(i);
      }
      if (inside == best.pairs || inside.size() < 4) break;
      best = fit_to(p_H_, p_D_, std::move(inside));
    }
    return best;
  }

  Agreement find_widest() const {
    std::vector<Candidate> top;
    std::vector<double> r2(n_);
    by_median_.clear();
    for_each_triple([&](std::size_t i, std::size_t j, std::size_t k) {
      const dvec3 h[3] = {p_H_[i], p_H_[j], p_H_[k]}, d[3] = {p_D_[i], p_D_[j], p_D_[k]};
      Candidate candidate{fit_rigid(h, d), 0, 0};
      residuals(candidate.X_DH, r2);
      std::tie(candidate.score, candidate.count) = best_nfa(r2);
      keep(top, candidate);
      keep(by_median_, {candidate.X_DH, nth(r2, std::min(n_ - 1, n_ / 2 + 1)), 0});
      return static_cast<double>(top.front().count) / static_cast<double>(n_);
    });
    Agreement best;
    for (const Candidate& candidate : top) {
      const Fit fit = grow(candidate);
      const double nfa = nfa_of(fit);
      if (nfa < best.log_nfa) best = {fit, nfa};
    }
    return best;
  }

  struct Candidate {
    Pose X_DH;
    // A smaller score is better: logarithm of the NFA, or median of the squared residuals (m²).
    double score;
    std::size_t count;
  };

  template <class F>
  void for_each_triple(F visit) const {
    if (n_ <= 20) {  // at most 1140 triples exist, so all are tried
      for (std::size_t i = 0; i < n_; ++i) {
        for (std::size_t j = i + 1; j < n_; ++j) {
          for (std::size_t k = j + 1; k < n_; ++k) (void)visit(i, j, k);
        }
      }
      return;
    }
    // With 30 % good pairs, one triple in 37 is good, and the probability that none of 1500 triples is good is 1e-18.
    // Once many pairs agree, fewer triples suffice (1e-9).
    Noise random(1);
    double needed = 1500;
    for (int draw = 0; draw < needed; ++draw) {
      const std::size_t i = random.index(n_), j = random.index(n_), k = random.index(n_);
      if (i == j || j == k || i == k) continue;
      const double fraction = visit(i, j, k);
      needed = std::clamp(std::log(1e-9) / std::log1p(-std::min(0.99, fraction * fraction * fraction)), 100.0, 1500.0);
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

  // Index of a bin, four per octave, from the bits of the number. Sorting would take most of the time.
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
    if (top.size() == kKept && candidate.score >= top.back().score) return;
    const auto place = std::upper_bound(top.begin(), top.end(), candidate,
                                        [](const auto& a, const auto& b) { return a.score < b.score; });
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

  // Takes the pairs with residuals below rms × √quantile and fits again, until nothing changes. Small sets grow if the
  // quantile exceeds 5: normally distributed residuals limited to R (at most 3.8 σ) have an rms of at least R/√5.
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

  // Residuals up to this multiple of the coordinates' rounding error count as rounding errors.
  static constexpr double kArithmetic = 1e5;

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
  mutable std::vector<Candidate> by_median_;  // candidates sorted by median residual, collected by find_widest()
};

// Consensus for known noise: uses the motion with most pairs within a limit. Candidates are computed from triples of
// pairs with congruent triangles in H and D, and are refitted before counting (Chum, Matas & Kittler 2003).
class KnownNoise {
 public:
  KnownNoise(Points p_H, Points p_D, double sigma, double false_alarm)
      : p_H_(p_H), p_D_(p_D), n_(p_H.size()), edge_(5 * std::sqrt(2.0) * sigma) {
    const double floor = rounding_of(p_H, p_D);
    limit2_ =
        std::max(sigma * sigma * chi_squared_quantile(1 - false_alarm / static_cast<double>(n_), 3), floor * floor);
    edge_ = std::max(edge_, 2 * floor);
    // 95 % quantile of chi-squared, accurate to 1 % (Wilson & Hilferty 1931).
    const double dof = std::max(3.0, 3 * static_cast<double>(n_) - 6), w = 2 / (9 * dof);
    expected_ = std::max(sigma * sigma * dof * std::pow(1 - w + 1.645 * std::sqrt(w), 3),
                         static_cast<double>(n_) * floor * floor);
  }

  /// Finds the motion that most pairs follow. `all`: fit to all pairs. Sets of fewer than `least` pairs may be missed.
  Agreement find(const Fit& all, std::size_t least) const {
    Agreement best{grow(all, 0), 0};
    // If four of sixteen pairs agree, the probability that 3000 triples miss them is 1e-9. 4 n_³ random triples include
    // practically all triples.
    const double most = std::min(3000.0, 4 * std::pow(static_cast<double>(n_), 3));
    double needed = needed_for(std::max(least, best.fit.pairs.size()));
    if (needed == 0 && cost(best.fit) > expected_) needed = needed_for(n_ / 2);
    SplitMix64 random{1};
    std::vector<bool> agrees(n_);
    const auto mark = [&] {
      agrees.assign(n_, false);
      for (const std::size_t i : best.fit.pairs) agrees[i] = true;
    };
    mark();
    for (double draw = 0; draw < std::min(needed, most); ++draw) {
      const std::size_t i = random_index(random, n_), j = random_index(random, n_), k = random_index(random, n_);
      if (i == j || j == k || i == k || !same_length(i, j) || !same_length(j, k) || !same_length(i, k)) continue;
      // If all three pairs already agree, the triple gives the same motion again.
      if (agrees[i] && agrees[j] && agrees[k] && best.fit.sse <= expected_) continue;
      const dvec3 h[3] = {p_H_[i], p_H_[j], p_H_[k]}, d[3] = {p_D_[i], p_D_[j], p_D_[k]};
      const std::size_t have = best.fit.pairs.size();
      const Fit fit = grow({fit_rigid(h, d), {}, 0}, have / 2);
      const std::size_t found = fit.pairs.size();
      if (cost(fit) >= cost(best.fit)) continue;
      best.fit = fit;
      mark();
      needed = needed_for(std::max(least, found));
    }
    // Computes the expected number of chance agreements (NFA), as the class Consensus does.
    const auto n = static_cast<double>(n_), k = static_cast<double>(best.fit.pairs.size());
    if (k < 4) return {std::move(best.fit)};
    const double edge = std::max({extent(p_H_), extent(p_D_), 1e-300});
    const double log_alpha = std::min(0.0, std::log(4 * kPi / 3) + 1.5 * std::log(limit2_) - 3 * std::log(edge));
    best.log_nfa = std::log(n) + std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) +
                   std::log(k * (k - 1) * (k - 2) / 6) + (k - 3) * log_alpha;
    return best;
  }

 private:
  bool same_length(std::size_t i, std::size_t j) const {
    return std::abs(glm::length(p_H_[i] - p_H_[j]) - glm::length(p_D_[i] - p_D_[j])) <= edge_;
  }

  /// Σ residual², m². A pair whose residual exceeds the limit counts as limit² (Torr & Zisserman 2000); if it counted
  /// as 0, the fit would gain by moving pairs beyond the limit.
  double cost(const Fit& fit) const { return fit.sse + static_cast<double>(n_ - fit.pairs.size()) * limit2_; }

  double needed_for(std::size_t count) const {
    const auto n = static_cast<double>(n_), k = static_cast<double>(count);
    if (count == n_) return 0;
    return std::log(1e-9) / std::log1p(-std::min(0.99, k * (k - 1) * (k - 2) / (n * (n - 1) * (n - 2))));
  }

  // Fits again to the pairs that agree, until nothing changes. Stops if fewer than `least` agree.
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
  // Sum of the squared residuals that the good pairs do not exceed with a probability of 95 %, m².
  double expected_ = 0;
};

}  // namespace

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

double sigma_of(const Fit& fit) {
  return std::sqrt(fit.sse / (3 * static_cast<double>(fit.pairs.size()) - 6));
}

std::size_t followers(Points p_H, Points p_D, const Pose& X_DH, double limit) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < p_H.size(); ++i) count += glm::length(X_DH * p_H[i] - p_D[i]) <= limit;
  return count;
}

double rounding_of(Points p_H, Points p_D) {
  double largest = 0;
  for (const Points points : {p_H, p_D}) {
    for (const dvec3& p : points) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  }
  return 64 * std::numeric_limits<double>::epsilon() * largest;
}

Agreement max_agreement(Points p_H, Points p_D, const RegistrationOptions& options, std::size_t least) {
  if (!(options.known_sigma > 0)) return Consensus(p_H, p_D, options.false_alarm).find();
  Indices everyone(p_H.size());
  std::iota(everyone.begin(), everyone.end(), 0u);
  const KnownNoise search(p_H, p_D, options.known_sigma, options.false_alarm);
  return search.find(fit_to(p_H, p_D, std::move(everyone)), least);
}

}  // namespace typodont::calibration
