// Conversions between predictor coefficients, reflection coefficients and autocorrelation.
#pragma once

#include <vector>

namespace typodont::audio {

/// Step-up recursion: converts reflection coefficients k_1…k_p to a_1…a_p of A(z) = 1 + Σ a_i z^-i.
std::vector<double> step_up(const std::vector<double>& reflection);
/// Step-down recursion: converts a_1…a_p to k_1…k_p, from the highest order down. Stops at |k| ≥ 1; the coefficients of
/// lower order are then 0. Stable if and only if all |k| < 1.
std::vector<double> step_down(std::vector<double> a);
/// Levinson–Durbin recursion: converts an autocorrelation r_0…r_p to reflection coefficients k_1…k_p.
std::vector<double> reflection_of_autocorrelation(const std::vector<double>& r);
/// |A|² at the frequency `angle` (2π: sampling rate), computed by the lattice recursion, because predictor coefficients
/// can be very large.
double predictor_power(const std::vector<double>& reflection, double angle);
/// Power gain²/|A|² at `count` frequencies from 0 to half the sampling rate.
std::vector<double> sampled_power(const std::vector<double>& reflection, double gain, std::size_t count);
/// Stable model with the smallest Itakura–Saito distance to `power` (at the frequencies of sampled_power()), by
/// autocorrelation and Levinson–Durbin. `gain`: standard deviation of the residual.
std::vector<double> reflection_of_power(const std::vector<double>& power, std::size_t order, double& gain);

}  // namespace typodont::audio
