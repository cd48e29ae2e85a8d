// Conversions between the three forms of an AR model: predictor coefficients, reflection coefficients, autocorrelation.
#pragma once

#include <vector>

namespace typodont::audio {

/// Step-up recursion: converts reflection coefficients k_1…k_p to predictor coefficients a_1…a_p of A(z) = 1 + Σ a_i
/// z^-i.
std::vector<double> step_up(const std::vector<double>& reflection);
/// Step-down recursion: converts predictor coefficients a_1…a_p to reflection coefficients k_1…k_p. The filter is
/// stable if and only if every |k| < 1. The recursion runs from the highest order down and stops at the first |k| ≥ 1;
/// the remaining k stay 0.
std::vector<double> step_down(std::vector<double> a);
/// Levinson–Durbin recursion: converts an autocorrelation r_0…r_p to reflection coefficients k_1…k_p.
std::vector<double> reflection_of_autocorrelation(const std::vector<double>& r);
/// Returns |A|², where A is the prediction-error filter, at an angular frequency (rad; 2π is the sampling rate). It is
/// computed by the lattice recursion, without the predictor coefficients, which can be huge although all |k| < 1.
double predictor_power(const std::vector<double>& reflection, double angle);
/// Returns the model's power spectrum gain²/|A|² (A: prediction-error filter) at `count` evenly spaced frequencies from
/// 0 to half the sampling rate, both included.
std::vector<double> sampled_power(const std::vector<double>& reflection, double gain, std::size_t count);
/// Returns the stable model whose power spectrum has the least Itakura–Saito distance to `power`. `power` is given at
/// the same frequencies as in sampled_power(). A Fourier transform gives the autocorrelation, then Levinson–Durbin
/// gives the reflection coefficients. `gain` receives the standard deviation of the residual.
std::vector<double> reflection_of_power(const std::vector<double>& power, std::size_t order, double& gain);

}  // namespace typodont::audio
