// The psychometric function of two-alternative trials, and its fit. Contains only computations; for any thread.
#pragma once

#include <span>

namespace typodont {

/// One answered trial: the difference between the stimuli, and the stimulus that the subject judged to be greater.
struct Judgement {
  double difference = 0;  // second stimulus minus first stimulus, in percent of the reference or in ms
  bool second = false;    // true: the subject judged the second stimulus to be greater
};

/// Probability of the answer "second": P = lapse / 2 + (1 − lapse) Φ((difference − bias) / width), where Φ is the
/// cumulative Gaussian (García-Pérez & Alcalá-Quintana 2011; lapse rate as in Wichmann & Hill 2001).
struct Psychometric {
  /// difference at which both answers are equally likely; not 0 if the order of the stimuli affects the answer
  double bias = 0;
  double width = 1;  // standard deviation of the subject's judgement, in the unit of the difference
  double lapse = 0;  // 0..1, fraction of trials that are answered at random

  double second(double difference) const noexcept;
  /// Returns the just-noticeable difference: the difference at which 75 % of the answers would be right if there were
  /// no bias and no lapses.
  double jnd() const noexcept;
  static double width_of_jnd(double jnd) noexcept;
};

/// An estimate with its 95 % confidence interval. If an end of the interval cannot be computed from the answers, a
/// fixed value is used for this end: 0 or infinity for the just-noticeable difference, the smallest or largest
/// difference of the trials for the bias.
struct Estimate {
  double value = 0, low = 0, high = 0;
};

struct PsychometricFit {
  Psychometric function;
  Estimate jnd, bias;
  double log_likelihood = 0;
};

inline constexpr double kMostLapses = 0.06;  // largest lapse rate in the fit (Wichmann & Hill 2001)

/// Fits the function by maximum likelihood. The confidence intervals come from the profile likelihood (χ² with one
/// degree of freedom). Requires at least one judgement with a difference other than 0. The bias is limited to the range
/// of the differences. If the trials come from an adaptive staircase, the estimate of the just-noticeable difference is
/// too low: after 80 trials by 5 to 10 % on average. This is a known effect (Kaernbach 2001). But the confidence
/// interval still contains the true value in 95 % of the cases.
PsychometricFit fit_psychometric(std::span<const Judgement> judgements);

/// Returns the fraction chosen / count with its exact 95 % confidence interval (Clopper & Pearson 1934).
Estimate fraction_of(int chosen, int count);
/// Returns the p-value of a two-sided binomial test. If both answers are equally likely, about half of `count` answers
/// are chosen. The p-value is the probability of a number that differs from this half by at least as much as `chosen`
/// does.
double chance_of(int chosen, int count);

}  // namespace typodont
