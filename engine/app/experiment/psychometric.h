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
  double bias = 0;   // difference that is called greater half of the time: the effect of the order
  double width = 1;  // standard deviation of what is judged
  double lapse = 0;  // 0..1, share of trials that are answered by chance

  double second(double difference) const noexcept;
  /// Just-noticeable difference: without bias and lapses, 75 % of the answers are right there.
  double jnd() const noexcept;
  static double width_of_jnd(double jnd) noexcept;
};

/// An estimate with its 95 % interval. An end that the answers do not determine is 0 or infinite for the JND, and the
/// end of the range of differences for the bias.
struct Estimate {
  double value = 0, low = 0, high = 0;
};

struct PsychometricFit {
  Psychometric function;
  Estimate jnd, bias;
  double log_likelihood = 0;
};

inline constexpr double kMostLapses = 0.06;  // greatest lapse rate that the fit considers (Wichmann & Hill 2001)

/// Maximum likelihood; intervals from the profile likelihood (χ² of one degree of freedom). At least one judgement, and
/// a difference other than 0. The bias is looked for within the range of the differences. As known of staircases
/// (Kaernbach 2001), the value is a little low: by 5 to 10 % on average after 80 trials; the interval allows for that.
PsychometricFit fit_psychometric(std::span<const Judgement> judgements);

/// Of `count` trials `chosen` were answered one way: their share with its exact 95 % interval (Clopper & Pearson 1934).
Estimate share_of(int chosen, int count);
/// Probability of answers as uneven as these, or more so, if both were equally likely (two-sided binomial test).
double chance_of(int chosen, int count);

}  // namespace typodont
