#include "engine/app/experiment/psychometric.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <vector>

namespace typodont {

namespace {

using Binomial = boost::math::binomial_distribution<double>;

constexpr double kUpperQuartile = 0.6744897501960817;  // Φ(0.6745) = 0.75
constexpr double kChiSquare95 = 3.841458820694124;     // 95 % quantile, one degree of freedom
constexpr double kMinProbability = 1e-12;              // lower limit of a probability: the likelihood never becomes 0
// The width is searched between smallest difference / kWidthRange and largest difference · kWidthRange.
constexpr double kWidthRange = 50;

double cumulative_gaussian(double x) {
  return 0.5 * std::erfc(-x / std::sqrt(2.0));
}

/// Number of answers at one difference between the stimuli, and how many of these answers were "second".
struct AnswersAt {
  double difference = 0, count = 0, second = 0;
};

/// Position of the maximum of `f`: first on a grid, then by Brent's method near the best grid point.
double maximize(const std::function<double(double)>& f, double low, double high, int grid) {
  constexpr int kBits = 20;  // bits of precision in Brent's method
  int best = 0;
  double most = -std::numeric_limits<double>::infinity();
  const double width = (high - low) / grid;
  for (int i = 0; i <= grid; ++i) {
    const double value = f(low + i * width);
    if (value > most) most = value, best = i;
  }
  const double a = low + std::max(best - 1, 0) * width, b = low + std::min(best + 1, grid) * width;
  return boost::math::tools::brent_find_minima([&](double x) { return -f(x); }, a, b, kBits).first;
}

class Likelihood {
 public:
  explicit Likelihood(std::span<const Judgement> judgements) {
    std::map<double, AnswersAt> levels;
    for (const Judgement& j : judgements) {
      AnswersAt& level = levels[j.difference];
      level.difference = j.difference, level.count += 1, level.second += j.second;
    }
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [difference, level] : levels) {
      levels_.push_back(level);
      greatest_ = std::max(greatest_, std::abs(difference));
      if (difference != 0) least = std::min(least, std::abs(difference));
    }
    shares_.resize(levels_.size());
    low_ = std::log(least / kWidthRange), high_ = std::log(greatest_ * kWidthRange);
  }

  /// Finds the lapse rate with the largest log-likelihood for this bias and width (the function is concave). Returns
  /// the log-likelihood.
  double best(double bias, double width, double& lapse) {
    for (std::size_t i = 0; i < levels_.size(); ++i)
      shares_[i] = cumulative_gaussian((levels_[i].difference - bias) / width);
    double low = 0, high = kMaxLapses;
    if (slope(low) <= 0) {
      high = low;
    } else if (slope(high) >= 0) {
      low = high;
    }
    for (int i = 0; i < 20 && low < high; ++i) {
      const double middle = 0.5 * (low + high);
      (slope(middle) > 0 ? low : high) = middle;
    }
    lapse = 0.5 * (low + high);
    double sum = 0;
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      const double p = probability(i, lapse);
      sum += levels_[i].second * std::log(p) + (levels_[i].count - levels_[i].second) * std::log(1 - p);
    }
    return sum;
  }

  double of_width(double log_width, double& bias) {
    const double width = std::exp(log_width);
    double lapse = 0;
    bias = maximize([&](double b) { return best(b, width, lapse); }, -greatest_, greatest_, 16);
    return best(bias, width, lapse);
  }
  double of_bias(double bias) {
    double lapse = 0;
    const double width = maximize([&](double w) { return best(bias, std::exp(w), lapse); }, low_, high_, 24);
    return best(bias, std::exp(width), lapse);
  }

  PsychometricFit fit() {
    PsychometricFit fit;
    double bias = 0;
    const double log_width = maximize([&](double w) { return of_width(w, bias); }, low_, high_, 24);
    of_width(log_width, bias);
    fit.function.bias = bias, fit.function.width = std::exp(log_width);
    fit.log_likelihood = best(bias, fit.function.width, fit.function.lapse);

    const double least = fit.log_likelihood - 0.5 * kChiSquare95;
    const auto width_inside = [&](double w) { return of_width(w, bias) >= least; };
    const auto bias_inside = [&](double b) { return of_bias(b) >= least; };
    fit.jnd.value = fit.function.jnd();
    fit.jnd.low = width_inside(low_) ? 0 : kUpperQuartile * std::exp(border(width_inside, log_width, low_));
    fit.jnd.high = width_inside(high_) ? std::numeric_limits<double>::infinity()
                                       : kUpperQuartile * std::exp(border(width_inside, log_width, high_));
    const double found = fit.function.bias;
    fit.bias.value = found;
    fit.bias.low = bias_inside(-greatest_) ? -greatest_ : border(bias_inside, found, -greatest_);
    fit.bias.high = bias_inside(greatest_) ? greatest_ : border(bias_inside, found, greatest_);
    return fit;
  }

 private:
  double probability(std::size_t i, double lapse) const {
    return std::clamp(0.5 * lapse + (1 - lapse) * shares_[i], kMinProbability, 1 - kMinProbability);
  }
  /// Derivative of the log-likelihood with respect to the lapse rate.
  double slope(double lapse) const {
    double sum = 0;
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      const double p = probability(i, lapse), k = levels_[i].second, n = levels_[i].count;
      sum += (k / p - (n - k) / (1 - p)) * (0.5 - shares_[i]);
    }
    return sum;
  }
  /// Finds the end of an interval by bisection between `in`, a point inside it, and `out`, a point outside.
  static double border(const std::function<bool(double)>& inside, double in, double out) {
    for (int i = 0; i < 24; ++i) {
      const double middle = 0.5 * (in + out);
      (inside(middle) ? in : out) = middle;
    }
    return 0.5 * (in + out);
  }

  std::vector<AnswersAt> levels_;
  std::vector<double> shares_;  // Φ((difference − bias) / width) at each level
  double greatest_ = 0;         // largest absolute difference between the stimuli of a trial
  double low_ = 0, high_ = 0;   // logarithms of the smallest and largest width of the psychometric function
};

}  // namespace

double Psychometric::second(double difference) const noexcept {
  return 0.5 * lapse + (1 - lapse) * cumulative_gaussian((difference - bias) / width);
}
double Psychometric::jnd() const noexcept {
  return kUpperQuartile * width;
}
double Psychometric::width_of_jnd(double jnd) noexcept {
  return jnd / kUpperQuartile;
}

PsychometricFit fit_psychometric(std::span<const Judgement> judgements) {
  return Likelihood(judgements).fit();
}

Estimate fraction_of(int chosen, int count) {
  constexpr double kTail = 0.025;  // probability outside the 95 % interval, on each side
  return {static_cast<double>(chosen) / count, Binomial::find_lower_bound_on_p(count, chosen, kTail),
          Binomial::find_upper_bound_on_p(count, chosen, kTail)};
}

double chance_of(int chosen, int count) {
  const int more = std::max(chosen, count - chosen);
  // Two-sided test: twice the tail of one side.
  return std::min(1.0, 2 * cdf(complement(Binomial(count, 0.5), more - 1)));
}

}  // namespace typodont
