// Conversions between the three forms of an AR model: predictor coefficients, reflection coefficients, autocorrelation.
#pragma once

#include <vector>

namespace typodont::audio {

/// k_1…k_p → a_1…a_p of A(z) = 1 + Σ a_i z^-i (step-up).
std::vector<double> step_up(const std::vector<double>& reflection);
/// a_1…a_p → k_1…k_p (step-down). The filter is stable if and only if every |k| < 1. The recursion runs from the
/// highest order down and stops at the first |k| ≥ 1; the remaining k stay 0.
std::vector<double> step_down(std::vector<double> a);
/// Levinson–Durbin: r_0…r_p → k_1…k_p.
std::vector<double> reflection_of_autocorrelation(const std::vector<double>& r);
/// |A|² at an angular frequency (rad; 2π is the sampling rate), computed by the lattice recursion. The recursion
/// needs no predictor coefficients, which can be huge although all |k| < 1.
double predictor_power(const std::vector<double>& reflection, double angle);
/// gain²/|A|² at `count` evenly spaced frequencies from 0 to half the sampling rate, both included.
std::vector<double> sampled_power(const std::vector<double>& reflection, double gain, std::size_t count);
/// The stable model whose power spectrum has the least Itakura–Saito distance to `power`, given on the grid of
/// sampled_power(). Computes the autocorrelation by a Fourier transform, then Levinson–Durbin. Returns k; `gain`
/// receives the standard deviation of the residual.
std::vector<double> reflection_of_power(const std::vector<double>& power, std::size_t order, double& gain);

}  // namespace typodont::audio
