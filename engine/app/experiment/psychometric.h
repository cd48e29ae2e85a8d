// The psychometric function of two-alternative trials, and its fit. Plain mathematics; any thread.
#pragma once

#include <span>

namespace typodont {

/// One answered trial: by how much the second stimulus exceeded the first, and which one was called greater.
struct Judgement {
  double difference = 0;  // second − first, in the experiment's unit (percent of the reference, or ms)
  bool second = false;    // the answer was "second"
};

/// P("second") = lapse / 2 + (1 − lapse) Φ((difference − bias) / width), Φ the cumulative Gaussian
/// (García-Pérez & Alcalá-Quintana 2011; lapse rate as in Wichmann & Hill 2001).
struct Psychometric {
  double bias = 0;   // difference at which both answers are equally likely; it measures the effect of the order
  double width = 1;  // standard deviation of the subject's judgement, in the unit of the difference
  double lapse = 0;  // 0..1, fraction of trials that are answered at random

  double second(double difference) const noexcept;
  /// Just-noticeable difference: without bias and lapses, 75 % of the answers are right there.
  double jnd() const noexcept;
  static double width_of_jnd(double jnd) noexcept;
};

/// An estimate with its 95 % confidence interval. If the answers do not determine an end of the interval, it is 0 or
/// infinite for the just-noticeable difference, and the end of the range of differences for the bias.
struct Estimate {
  double value = 0, low = 0, high = 0;
};

struct PsychometricFit {
  Psychometric function;
  Estimate jnd, bias;
  double log_likelihood = 0;
};

inline constexpr double kMostLapses = 0.06;  // greatest lapse rate that the fit considers (Wichmann & Hill 2001)

/// Fits by maximum likelihood; the intervals come from the profile likelihood (χ² with one degree of freedom). Needs at
/// least one judgement with a difference other than 0. The bias is limited to the range of the differences. After an
/// adaptive staircase the just-noticeable difference is estimated 5 to 10 % too low on average after 80 trials, which
/// is a known effect (Kaernbach 2001); the interval still contains the true value in 95 % of the cases.
PsychometricFit fit_psychometric(std::span<const Judgement> judgements);

/// The fraction chosen / count with its exact 95 % interval (Clopper & Pearson 1934).
Estimate fraction_of(int chosen, int count);
/// Probability that `chosen` of `count` answers, or a more uneven result, occurs if both answers are equally likely
/// (two-sided binomial test).
double chance_of(int chosen, int count);

}  // namespace typodont
