// Between the three faces of one AR model: predictor coefficients, reflection coefficients, autocorrelation.
#pragma once

#include <vector>

namespace typodont::audio {

/// k_1…k_p → a_1…a_p of A(z) = 1 + Σ a_i z^-i (step-up).
std::vector<double> step_up(const std::vector<double>& reflection);
/// a_1…a_p → k_1…k_p (step-down). The filter is stable exactly when every |k| < 1; beyond the first |k| ≥ 1, counted
/// from the highest order, the recursion says nothing more and the lower k are left 0.
std::vector<double> step_down(std::vector<double> a);
/// Levinson–Durbin: r_0…r_p → k_1…k_p.
std::vector<double> reflection_of_autocorrelation(const std::vector<double>& r);
/// |A|² at an angle (rad, 2π is the sampling rate), by the lattice's own recursion: no predictor coefficients, which
/// may be huge where the k are harmless.
double predictor_power(const std::vector<double>& reflection, double angle);
/// gain²/|A|² at `count` frequencies from 0 to half the rate, both included.
std::vector<double> sampled_power(const std::vector<double>& reflection, double gain, std::size_t count);
/// The stable model whose power spectrum, on the same grid as sampled_power, is nearest to `power` (least
/// Itakura–Saito distance): its autocorrelation by Fourier, then Levinson. Returns k; `gain` receives the residual's
/// standard deviation.
std::vector<double> reflection_of_power(const std::vector<double>& power, std::size_t order, double& gain);

}  // namespace typodont::audio
