// The psychometric function of two-alternative trials, and its fit. Any thread.
#pragma once

#include <span>

namespace typodont {

/// The answer to one trial.
struct Judgement {
  double difference = 0;  // second stimulus minus first, % of the reference or ms
  bool second = false;    // true: the second stimulus was judged greater
};

/// Probability of the answer "second": lapse / 2 + (1 − lapse) Φ((difference − bias) / width). From García-Pérez &
/// Alcalá-Quintana 2011; lapse rate as in Wichmann & Hill 2001.
struct Psychometric {
  /// Difference at which both answers are equally likely; not 0 if the order of the stimuli matters.
  double bias = 0;
  double width = 1;  // standard deviation of the judgement
  double lapse = 0;  // 0 to 1, fraction of random answers

  double second(double difference) const noexcept;
  /// Just-noticeable difference: 75 % right answers, without bias and lapses.
  double jnd() const noexcept;
  static double width_of_jnd(double jnd) noexcept;
};

/// A value with its 95 % interval. If the answers do not determine a limit, it is 0 or infinity for a just-noticeable
/// difference, and the smallest or largest tested difference for a bias.
struct Estimate {
  double value = 0, low = 0, high = 0;
};

struct PsychometricFit {
  Psychometric function;
  Estimate jnd, bias;
  double log_likelihood = 0;
};

inline constexpr double kMaxLapses = 0.06;  // upper limit of the lapse rate (Wichmann & Hill 2001)

/// Fits by maximum likelihood, with intervals from the profile likelihood (χ², one degree of freedom). Needs a
/// judgement with a difference other than 0. The bias is limited to the range of differences. Staircases bias the
/// just-noticeable difference by −5 to −10 % after 80 trials (Kaernbach 2001); the interval still covers the true
/// difference in 95 % of cases.
PsychometricFit fit_psychometric(std::span<const Judgement> judgements);

/// The fraction chosen / count with its exact 95 % interval (Clopper & Pearson 1934).
Estimate fraction_of(int chosen, int count);
/// p-value of a two-sided binomial test of chosen/count against 1/2.
double chance_of(int chosen, int count);

}  // namespace typodont
