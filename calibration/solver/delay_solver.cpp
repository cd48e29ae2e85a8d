// The stream with fewer samples is interpolated at the times of the denser one, which adds the least noise. This noise
// would bias the result of least squares, so the equations use an instrumental variable: the denser stream's slope,
// computed without the sample itself.
#include "calibration/delay_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "calibration/registration_solver.h"
#include "calibration/solver/eigen_math.h"
#include "engine/base/error.h"

namespace typodont::calibration {

namespace {

using Eigen::Vector3d;

constexpr std::size_t kThrough = 6;  // number of samples through which an interpolating polynomial goes

// A stream without frozen samples, split into segments at gaps.
struct Track {
  std::vector<double> t;
  std::vector<dvec3> p;
  std::vector<std::size_t> begin, end;  // for each sample: begin and end of its segment
  double step = 0;                      // s, median sample interval
  int lost = 0, frozen = 0;
  // Denominators of the Lagrange polynomial through a sample and the next five.
  std::vector<std::array<double, kThrough>> denominators;
};

Track clean(const Stream& stream, const char* which) {
  if (stream.t.size() != stream.p.size())
    throw Error(fmt::format("stream {}: as many times as points expected", which));
  if (stream.t.size() < 16) {
    throw Error(fmt::format("stream {}: found {} samples, expected at least 16", which, stream.t.size()));
  }
  for (std::size_t i = 1; i < stream.t.size(); ++i) {
    if (!(stream.t[i] > stream.t[i - 1])) {
      throw Error(fmt::format("stream {}: sample {}: found time {} after {}, expected increasing times", which, i,
                              stream.t[i], stream.t[i - 1]));
    }
  }
  Track track;
  // Repeated equal samples mean a frozen sensor; or a coarse encoder, if most samples are repeated.
  int repeats = 0;
  for (std::size_t i = 1; i < stream.t.size(); ++i) repeats += stream.p[i] == stream.p[i - 1];
  const bool drop = 10 * repeats < 4 * static_cast<int>(stream.t.size());
  for (std::size_t i = 0; i < stream.t.size(); ++i) {
    if (drop && i > 0 && stream.p[i] == stream.p[i - 1]) {
      ++track.frozen;
      continue;
    }
    track.t.push_back(stream.t[i]), track.p.push_back(stream.p[i]);
  }
  std::vector<double> steps;
  for (std::size_t i = 1; i < track.t.size(); ++i) steps.push_back(track.t[i] - track.t[i - 1]);
  track.step = median(steps);
  for (const double gap : steps) {
    if (gap > 1.5 * track.step) track.lost += static_cast<int>(std::lround(std::min(gap / track.step, 1e6))) - 1;
  }
  const std::size_t n = track.t.size();
  track.begin.resize(n), track.end.resize(n);
  for (std::size_t i = 0; i < n;) {
    std::size_t stop = i + 1;
    while (stop < n && track.t[stop] - track.t[stop - 1] < 2.5 * track.step) ++stop;
    for (std::size_t k = i; k < stop; ++k) track.begin[k] = i, track.end[k] = stop;
    i = stop;
  }
  track.lost = std::max(0, track.lost - track.frozen);
  track.denominators.resize(n >= kThrough ? n - kThrough + 1 : 0);
  for (std::size_t first = 0; first < track.denominators.size(); ++first) {
    const double* t = &track.t[first];
    for (std::size_t j = 0; j < kThrough; ++j) {
      double& denominator = track.denominators[first][j] = 1;
      for (std::size_t k = 0; k < kThrough; ++k) {
        if (k != j) denominator *= (t[j] - t[k]) / track.step;
      }
    }
  }
  return track;
}

struct Interpolated {
  bool valid = false;
  dvec3 p{0, 0, 0}, v{0, 0, 0};
  double noise_gain = 1;  // variance of the interpolated position divided by the variance of a sample
};

// Lagrange interpolation through six samples around the time u, without gaps.
Interpolated interpolate(const Track& track, double u, std::size_t& hint) {
  const std::size_t n = track.t.size();
  if (!(u >= track.t.front() && u <= track.t.back())) return {};
  if (hint >= n - 1 || track.t[hint] > u || track.t[std::min(n - 1, hint + 8)] < u) {
    hint = static_cast<std::size_t>(std::upper_bound(track.t.begin(), track.t.end(), u) - track.t.begin());
    hint = hint > 0 ? hint - 1 : 0;
  }
  while (hint + 1 < n && track.t[hint + 1] <= u) ++hint;
  const std::size_t i = std::min(hint, n - 2), low = track.begin[i], high = track.end[i];
  if (i + 1 >= high || high - low < kThrough) return {};
  const std::size_t first = std::min(std::max(i, low + 2) - 2, high - kThrough);
  const double* t = &track.t[first];
  double gap[kThrough];
  for (std::size_t j = 0; j < kThrough; ++j) gap[j] = (u - t[j]) / track.step;
  // without[j][k]: product of all gap[l] except l = j and l = k.
  double without[kThrough][kThrough];
  for (std::size_t j = 0; j < kThrough; ++j) {
    for (std::size_t k = 0; k < j; ++k) {
      double product = 1;
      for (std::size_t l = 0; l < kThrough; ++l) {
        if (l != j && l != k) product *= gap[l];
      }
      without[j][k] = without[k][j] = product;
    }
  }
  Interpolated result{true, dvec3(0), dvec3(0), 0};
  for (std::size_t j = 0; j < kThrough; ++j) {
    double weight = 1, slope = 0;
    for (std::size_t k = 0; k < kThrough; ++k) {
      if (k == j) continue;
      weight *= gap[k];
      slope += without[j][k];
    }
    const double denominator = track.denominators[first][j];
    weight /= denominator, slope /= denominator * track.step;
    result.p += weight * track.p[first + j];
    result.v += slope * track.p[first + j];
    result.noise_gain += weight * weight;
  }
  return result;
}

// Velocity (m/s) at sample k by regression over the samples k ± 1 … k ± m, without k itself; nullopt across a gap.
std::optional<dvec3> slope_at(const Track& track, std::size_t k, std::size_t m) {
  if (k < track.begin[k] + m || k + m >= track.end[k]) return {};
  double mean_t = 0;
  dvec3 mean_p(0);
  for (std::size_t j = k - m; j <= k + m; ++j) {
    if (j != k) mean_t += track.t[j], mean_p += track.p[j];
  }
  const double count = 2 * static_cast<double>(m);
  mean_t /= count, mean_p /= count;
  double tt = 0;
  dvec3 v(0);
  for (std::size_t j = k - m; j <= k + m; ++j) {
    if (j == k) continue;
    const double dt = track.t[j] - mean_t;
    tt += dt * dt;
    v += dt * (track.p[j] - mean_p);
  }
  return v / tt;
}

// Noise of the positions per axis (m), from fourth differences: variance 70 σ² for white noise, 0 for smooth motion.
double noise_of(const Track& track) {
  std::vector<double> magnitude;
  for (std::size_t i = 4; i < track.t.size(); ++i) {
    if (i < track.begin[i] + 4) continue;
    const dvec3 d = track.p[i] - 4.0 * track.p[i - 1] + 6.0 * track.p[i - 2] - 4.0 * track.p[i - 3] + track.p[i - 4];
    magnitude.push_back(glm::dot(d, d));
  }
  // Median of |d|²: 70 σ² × 2.366. 70: sum of 1², 4², 6², 4², 1²; 2.366: median of chi-squared (3 degrees of freedom).
  return std::sqrt(median(magnitude) / (70 * 2.365974));
}

struct Shift {
  double u = 0;     // s, delay of the query: query(t) = sparse(t - u - rate (t - middle of the interval))
  double rate = 0;  // s/s, relative difference of the rates of the two clocks
};

class Matcher {
 public:
  Matcher(const Track& query, const Track& sparse) : query_(query), sparse_(sparse) {
    start_ = std::max(query.t.front(), sparse.t.front());
    end_ = std::min(query.t.back(), sparse.t.back());
  }

  double start() const { return start_; }
  double end() const { return end_; }

  /// Mean squared difference in the first `horizon` seconds, after a shift by `u` and the best translation (`rotate`:
  /// rigid motion).
  double mismatch(double u, bool rotate, double horizon, std::size_t stride) const {
    std::vector<dvec3>&h = scratch_a_, &d = scratch_b_;
    h.clear(), d.clear();
    std::size_t hint = 0;
    const double stop = start_ + horizon;
    for (std::size_t k = 0; k < query_.t.size() && query_.t[k] <= stop; k += stride) {
      const Interpolated s = interpolate(sparse_, query_.t[k] - u, hint);
      if (s.valid) h.push_back(s.p), d.push_back(query_.p[k]);
    }
    if (h.size() < 12) return std::numeric_limits<double>::infinity();
    Pose X;
    if (rotate) {
      X = fit_rigid(h, d);
    } else {
      for (std::size_t i = 0; i < h.size(); ++i) X.p += (d[i] - h[i]) / static_cast<double>(h.size());
    }
    // Limits the influence of glitches: at most 1.5 times the mean that normal errors with the residuals' median have.
    scratch_r_.clear();
    double sum = 0;
    for (std::size_t i = 0; i < h.size(); ++i) {
      const dvec3 r = X * h[i] - d[i];
      scratch_r_.push_back(glm::dot(r, r));
      sum += scratch_r_.back();
    }
    return std::min(sum / static_cast<double>(h.size()), 3 / 2.365974 * median(scratch_r_) * 1.5);
  }

  struct Solution {
    Shift shift;
    Pose X;  // maps positions of the sparser stream to the frame of the denser one (query)
    double variance_u = 0, covariance = 0, variance_rate = 0;
    double residual2 = 0;  // m² per axis, mean squared residual
    double noise_gain = 1;
    int samples = 0, rejected = 0;
    bool determined = false;
  };

  /// Refines the shift from a start near the minimum.
  Solution solve(Shift shift, bool rotate, bool skew, double horizon) const {
    const double stop = start_ + horizon, middle = 0.5 * (start_ + std::min(end_, stop));
    const int columns = 1 + (skew ? 1 : 0) + 3 + (rotate ? 3 : 0);
    Solution best;
    double best_information = 0;
    // Slopes over many samples (large m) have less noise; those over few follow fast motion. The best m is used.
    for (std::size_t m = 1; m <= 64; m *= 2) {
      Solution solution;
      solution.shift = shift;
      double limit2 = std::numeric_limits<double>::infinity();
      double information = 0;
      slopes_.clear();
      for (std::size_t k = 0; k < query_.t.size() && query_.t[k] <= stop; ++k)
        slopes_.push_back(slope_at(query_, k, m));
      for (int round = 0; round < 12; ++round) {
        // Builds the equations for the current shift.
        rows_.clear();
        std::size_t hint = 0;
        for (std::size_t k = 0; k < slopes_.size(); ++k) {
          Row row;
          row.dt = query_.t[k] - middle;
          const Interpolated s =
              interpolate(sparse_, query_.t[k] - solution.shift.u - solution.shift.rate * row.dt, hint);
          if (!s.valid || !slopes_[k]) continue;
          row.slope = *slopes_[k], row.s = s.p, row.v = s.v, row.q = query_.p[k], row.gain = s.noise_gain;
          rows_.push_back(row);
        }
        if (rows_.size() < 12) break;
        if (round == 0) solution.X = align(rotate);
        Eigen::Matrix<double, 8, 8> ZG = Eigen::Matrix<double, 8, 8>::Zero(), ZZ = ZG;
        Eigen::Matrix<double, 8, 1> Zr = Eigen::Matrix<double, 8, 1>::Zero();
        const dvec3 centre = solution.X * rows_[rows_.size() / 2].s;
        double squares = 0, gain = 0;
        int used = 0;
        residuals_.clear();
        for (const Row& row : rows_) {
          const dvec3 at = solution.X * row.s;
          const dvec3 r = row.q - at;
          const double r2 = glm::dot(r, r);
          residuals_.push_back(r2);
          if (r2 > limit2) continue;
          // Derivatives of `at` by delay, rate, translation and rotation: -v, -v dt, 1, lever (v: velocity).
          Eigen::Matrix<double, 3, 8> G = Eigen::Matrix<double, 3, 8>::Zero(), Z = G;
          const Vector3d g = -eigen(solution.X.rotate(row.v)), z = -eigen(row.slope);
          int c = 0;
          G.col(c) = g, Z.col(c++) = z;
          if (skew) G.col(c) = g * row.dt, Z.col(c++) = z * row.dt;
          for (int i = 0; i < 3; ++i, ++c) G(i, c) = Z(i, c) = 1;
          if (rotate) {
            G.block<3, 3>(0, c) = Z.block<3, 3>(0, c) = -cross_matrix(at - centre);
          }
          ZG += Z.transpose() * G, ZZ += Z.transpose() * Z, Zr += Z.transpose() * eigen(r);
          squares += r2, gain += row.gain, ++used;
        }
        if (used < 12) break;
        const auto n = static_cast<Eigen::Index>(columns);
        const Eigen::MatrixXd A = ZG.topLeftCorner(n, n);
        // Scales the unknowns, because seconds, metres and radians differ by orders of magnitude.
        Eigen::VectorXd scale(n);
        for (Eigen::Index i = 0; i < n; ++i) scale[i] = ZZ(i, i) > 0 ? 1 / std::sqrt(ZZ(i, i)) : 1;
        const Decomposition scaled = decompose(scale.asDiagonal() * A);
        if (scaled.rank() < n) break;
        const Eigen::MatrixXd inverse =
            least_norm_solution(scaled, Eigen::MatrixXd::Identity(n, n)) * scale.asDiagonal();
        const Eigen::VectorXd step = inverse * Zr.head(n);
        const Eigen::MatrixXd spread = inverse.lazyProduct(ZZ.topLeftCorner(n, n));
        const Eigen::MatrixXd covariance = spread.lazyProduct(inverse.transpose());
        solution.residual2 = squares / (3.0 * used);
        solution.noise_gain = gain / used;
        solution.samples = used;
        solution.rejected = static_cast<int>(rows_.size()) - used;
        solution.variance_u = covariance(0, 0);
        solution.covariance = skew ? covariance(0, 1) : 0;
        solution.variance_rate = skew ? covariance(1, 1) : 0;
        information = 1 / covariance(0, 0);
        solution.determined = true;
        const double largest = 4 * sparse_.step;
        solution.shift.u += std::clamp(step[0], -largest, largest);
        int c = 1;
        if (skew) solution.shift.rate += std::clamp(step[c++], -1e-3, 1e-3);
        solution.X.p += dvec3(step[c], step[c + 1], step[c + 2]);
        if (rotate) {
          const dvec3 theta(step[c + 3], step[c + 4], step[c + 5]);
          const dquat turn = glm::normalize(dquat(1, 0.5 * theta.x, 0.5 * theta.y, 0.5 * theta.z));
          solution.X.p = turn * (solution.X.p - centre) + centre;
          solution.X.R = glm::normalize(turn * solution.X.R);
        }
        // Glitches (residuals above 7 robust standard deviations) are not used.
        const double robust = median(residuals_) / 2.365974;
        limit2 = round == 0 ? limit2 : std::max(49.0 * robust, 1e-24);
        if (round > 2 && std::abs(step[0]) < 1e-9 * sparse_.step + 1e-4 * std::sqrt(covariance(0, 0) * robust)) break;
      }
      if (solution.determined && std::isfinite(information) && information > best_information) {
        best_information = information, best = solution;
      }
    }
    return best;
  }

 private:
  struct Row {
    double dt = 0, gain = 1;
    dvec3 q, s, v, slope;
  };

  Pose align(bool rotate) const {
    std::vector<dvec3> h, d;
    for (const Row& row : rows_) h.push_back(row.s), d.push_back(row.q);
    if (rotate) return fit_rigid(h, d);
    Pose X;
    for (std::size_t i = 0; i < h.size(); ++i) X.p += (d[i] - h[i]) / static_cast<double>(h.size());
    return X;
  }

  const Track& query_;
  const Track& sparse_;
  double start_ = 0, end_ = 0;
  mutable std::vector<dvec3> scratch_a_, scratch_b_;
  mutable std::vector<double> scratch_r_, residuals_;
  mutable std::vector<Row> rows_;
  mutable std::vector<std::optional<dvec3>> slopes_;  // slope of the motion at each sample of query_; a cache
};

double variance_of(const Track& track) {
  dvec3 mean(0);
  for (const dvec3& p : track.p) mean += p / static_cast<double>(track.p.size());
  double sum = 0;
  for (const dvec3& p : track.p) sum += glm::dot(p - mean, p - mean);
  return sum / static_cast<double>(track.p.size());
}

struct Minimum {
  double u, mismatch;
};

}  // namespace

DelayResult estimate_delay(const Stream& a, const Stream& b, const DelayOptions& options) {
  const Track track_a = clean(a, "A"), track_b = clean(b, "B");
  DelayResult result;
  result.lost_a = track_a.lost, result.lost_b = track_b.lost;
  result.frozen_a = track_a.frozen, result.frozen_b = track_b.frozen;

  // The denser stream is the query; the other is interpolated.
  const bool a_asks = track_a.step < 0.95 * track_b.step;
  const Track& query = a_asks ? track_a : track_b;
  const Track& sparse = a_asks ? track_b : track_a;
  const double sign = a_asks ? -1 : 1;  // delay of stream B = sign · u; u: delay of `query`
  Matcher matcher(query, sparse);
  const double shared = matcher.end() - matcher.start();
  if (!(shared > 12 * sparse.step)) {
    throw Error(fmt::format("streams: A covers {} to {} s, B {} to {} s, expected recordings of the same moments",
                            track_a.t.front(), track_a.t.back(), track_b.t.front(), track_b.t.back()));
  }
  const double window = std::min(options.max_delay, 0.4 * shared);
  result.reference_time = matcher.start();
  const double motion = std::min(variance_of(track_a), variance_of(track_b));

  // A stream whose variance is that of its noise contains no information.
  const double sigma_q = noise_of(query), sigma_s = noise_of(sparse);
  const auto rests = [](const Track& track, double sigma) {
    return variance_of(track) <= 3 * sigma * sigma * (1 + 10 / std::sqrt(static_cast<double>(track.t.size()))) + 1e-20;
  };
  if (const bool q = rests(query, sigma_q), s = rests(sparse, sigma_s); q || s) {
    result.sigma = window / std::sqrt(3.0);
    result.noise = std::sqrt(sigma_q * sigma_q + sigma_s * sigma_s);
    result.ambiguous = true;
    result.reason =
        fmt::format("no motion: {} at rest, move the hand to and fro while recording", q && s ? "both streams are"
                                                                                       : q == a_asks ? "stream A is"
                                                                                                     : "stream B is");
    return result;
  }

  // Computes the mismatch for all delays: with a translation between the streams, then with a rigid motion.
  const double horizon = std::min(shared, std::max(30.0, 4 * window));
  const int half = std::min(1000, static_cast<int>(std::ceil(window / sparse.step)));
  const double step = window / half;
  const auto samples_in_horizon = static_cast<std::size_t>(horizon / query.step);
  const std::size_t stride = std::max<std::size_t>(1, samples_in_horizon / 400);
  struct Curve {
    std::vector<double> values;
    std::vector<Minimum> minima;  // minima of the mismatch over the delay, best first
    double best() const { return minima.empty() ? std::numeric_limits<double>::infinity() : minima.front().mismatch; }
  } curves[2];
  for (int rotate = 0; rotate < 2; ++rotate) {
    // Rotation is not tried if the streams agree without it.
    if (rotate == 1 && curves[0].best() < 4 * (sigma_q * sigma_q + sigma_s * sigma_s) && sigma_q + sigma_s > 0) break;
    Curve& curve = curves[rotate];
    for (int i = -half; i <= half; ++i) curve.values.push_back(matcher.mismatch(i * step, rotate, horizon, stride));
    for (int i = 0; i <= 2 * half; ++i) {
      const auto at = [&](int k) { return curve.values[static_cast<std::size_t>(std::clamp(k, 0, 2 * half))]; };
      if (!std::isfinite(at(i)) || at(i) > at(i - 1) || at(i) > at(i + 1) || at(i) > motion) continue;
      // Golden-section search in the interval around the minimum.
      double low = (i - half - 1) * step, high = (i - half + 1) * step;
      constexpr double kGolden = 0.6180339887498949;
      double x1 = high - kGolden * (high - low), x2 = low + kGolden * (high - low);
      double f1 = matcher.mismatch(x1, rotate, horizon, stride), f2 = matcher.mismatch(x2, rotate, horizon, stride);
      for (int round = 0; round < 18; ++round) {
        if (f1 < f2) {
          high = x2, x2 = x1, f2 = f1, x1 = high - kGolden * (high - low);
          f1 = matcher.mismatch(x1, rotate, horizon, stride);
        } else {
          low = x1, x1 = x2, f1 = f2, x2 = low + kGolden * (high - low);
          f2 = matcher.mismatch(x2, rotate, horizon, stride);
        }
      }
      curve.minima.push_back({f1 < f2 ? x1 : x2, std::min({f1, f2, at(i)})});
    }
    std::sort(curve.minima.begin(), curve.minima.end(), [](auto& x, auto& y) { return x.mismatch < y.mismatch; });
    if (curve.minima.size() > 40) curve.minima.resize(40);
  }
  // Minima up to 1.5 times the best one are plausible: interpolation scales noise by 0.7 to 1, and a difference of
  // clock rates flattens minima.
  const auto plausible_up_to = [&](double best) { return 1.5 * best + 1e-6 * motion; };
  const double significant = 1 + 60.0 / static_cast<double>(std::max<std::size_t>(1, samples_in_horizon / stride));
  result.rotated = curves[0].best() > significant * curves[1].best() + 1e-6 * motion;
  const Curve& curve = curves[result.rotated ? 1 : 0];

  const auto undetermined = [&](std::string why) {
    result.ambiguous = true;
    result.reason = std::move(why);
    result.rich = false;
  };
  std::vector<Minimum> plausible;
  for (const Minimum& m : curve.minima) {
    if (m.mismatch > plausible_up_to(curve.best())) continue;
    // If noise splits a minimum into two, they count as one minimum.
    const bool known = std::any_of(plausible.begin(), plausible.end(), [&](const Minimum& other) {
      const auto index = [&](double u) {
        return std::clamp(static_cast<int>(std::lround(u / step)) + half, 0, 2 * half);
      };
      for (int i = std::min(index(m.u), index(other.u)); i <= std::max(index(m.u), index(other.u)); ++i) {
        if (curve.values[static_cast<std::size_t>(i)] > plausible_up_to(curve.best()) &&
            std::min(std::abs(i - index(m.u)), std::abs(i - index(other.u))) > 1) {
          return false;
        }
      }
      return true;
    });
    if (!known) plausible.push_back(m);
  }
  if (plausible.empty()) {
    result.sigma = window / std::sqrt(3.0);
    undetermined("no delay within the searched range makes the streams agree: they may not show the same motion");
    return result;
  }
  std::sort(plausible.begin(), plausible.end(), [](auto& x, auto& y) { return std::abs(x.u) < std::abs(y.u); });

  // Refines the delay over growing intervals, because the clocks may have different rates.
  const auto refine = [&](double u, bool skew) {
    Matcher::Solution solution = matcher.solve({u, 0}, result.rotated, false, std::min(horizon, shared));
    if (!skew || !solution.determined) return solution;
    for (double reach = horizon;; reach = std::min(shared, 2 * reach)) {
      Shift from = solution.shift;
      // u is the shift at the interval's middle. A longer interval has a later middle, so u changes by rate × time.
      if (reach > horizon) from.u += from.rate * (0.25 * reach);
      const auto next = matcher.solve(from, result.rotated, true, reach);
      if (!next.determined) return solution;
      solution = next;
      if (reach >= shared) return solution;
    }
  };
  // Fraction of the residual's variance that the noise of the sparser stream causes.
  const double fraction = sigma_q + sigma_s > 0 ? sigma_s * sigma_s / (sigma_q * sigma_q + sigma_s * sigma_s) : 0.5;
  const double density = sparse.step / query.step;
  const auto noise2 = [&](const Matcher::Solution& s) {
    const double total = s.residual2 / (1 - fraction + fraction * s.noise_gain);
    return std::pair{total, total * (1 - fraction + fraction * density)};
  };
  const double u0 = plausible.front().u;
  Matcher::Solution solution = refine(u0, true);
  if (solution.determined) {
    const double rate_sigma = std::sqrt(solution.variance_rate * noise2(solution).second);
    // Rates of real clocks differ by less than 1e-3.
    if (std::abs(solution.shift.rate) > 3 * rate_sigma && std::abs(solution.shift.rate) < 1e-3) {
      result.skew = sign * solution.shift.rate, result.skew_sigma = rate_sigma;
    } else {
      const double start_u = solution.shift.u;
      solution =
          matcher.solve({std::abs(start_u - u0) < 4 * sparse.step ? start_u : u0, 0}, result.rotated, false, shared);
      result.skew_sigma = rate_sigma;
    }
  }
  const bool touches_edge =
      curve.values.front() <= plausible_up_to(curve.best()) || curve.values.back() <= plausible_up_to(curve.best());
  if (!solution.determined || !std::isfinite(solution.shift.u) || std::abs(solution.shift.u) > 1.5 * window) {
    result.delay = sign * u0;
    result.sigma = window / std::sqrt(3.0);
    undetermined("the motion does not determine the delay: it is constant in speed and direction");
    return result;
  }
  const auto [noise_total, noise_weighted] = noise2(solution);
  result.noise = std::sqrt(noise_total);
  result.samples = solution.samples;
  result.rejected = solution.rejected;
  double variance = solution.variance_u;
  double u = solution.shift.u;
  if (result.skew != 0) {
    const double to_start = -0.5 * shared;
    variance += to_start * (2 * solution.covariance + to_start * solution.variance_rate);
    u += to_start * solution.shift.rate;
  }
  result.delay = sign * u;
  result.delay_at_end = result.delay + result.skew * shared;
  result.sigma = std::min(std::sqrt(variance * noise_weighted), window / std::sqrt(3.0));
  result.X_BA = a_asks ? inverse(solution.X) : solution.X;
  for (const Minimum& m : plausible) result.candidates.push_back(sign * m.u);
  result.candidates.front() = result.delay;
  result.rich = result.sigma <= 1e-4;
  if (touches_edge) {
    result.sigma = window / std::sqrt(3.0);
    undetermined("the motion does not determine the delay: it is constant in speed and direction, or too small");
  } else if (plausible.size() > 1) {
    undetermined(fmt::format("the motion repeats itself: {} delays within ±{:.0f} ms explain it as well",
                             plausible.size(), window * 1e3));
  }
  return result;
}

}  // namespace typodont::calibration
