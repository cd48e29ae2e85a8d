// Predictor coefficients, reflection coefficients, autocorrelation.
#pragma once

#include <vector>

namespace typodont::audio {

/// Step-up: k_1…k_p to a_1…a_p of A(z) = 1 + Σ a_i z^-i.
std::vector<double> step_up(const std::vector<double>& reflection);
/// Step-down: a_1…a_p to k_1…k_p, from the highest order until |k| ≥ 1 (the rest stays 0). Stable iff all |k| < 1.
std::vector<double> step_down(std::vector<double> a);
/// Levinson–Durbin recursion: converts an autocorrelation r_0…r_p to reflection coefficients k_1…k_p.
std::vector<double> reflection_of_autocorrelation(const std::vector<double>& r);
/// |A|² at `angle` (2π: sampling rate), by the lattice recursion: predictor coefficients can be huge.
double predictor_power(const std::vector<double>& reflection, double angle);
/// gain²/|A|² at `count` frequencies from 0 to half the rate.
std::vector<double> sampled_power(const std::vector<double>& reflection, double gain, std::size_t count);
/// Stable model of least Itakura–Saito distance to `power` (frequencies of sampled_power()), by autocorrelation and
/// Levinson–Durbin. `gain`: σ of the residual.
std::vector<double> reflection_of_power(const std::vector<double>& power, std::size_t order, double& gain);

}  // namespace typodont::audio
