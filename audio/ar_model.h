// An autoregressive model: white noise filtered to the drill's spectrum. Stored as JSON.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace typodont::audio {

/// Slow process, one value per kLineStep samples; zero without coefficients and gain.
struct LineNoise {
  std::vector<double> reflection;  // reflection coefficients k_1 … k_p, each in (−1, 1)
  double gain = 0;                 // standard deviation of the process's residual

  double deviation() const;  // returns the standard deviation of the process
};
inline constexpr int kLineStep = 64;

/// A sinusoid with slowly varying amplitude and frequency: filtered noise would hiss instead of whistle.
struct ModelLine {
  double frequency = 0;       // Hz, mean frequency of the spectral line
  double amplitude = 0;       // mean amplitude; full scale is 1
  LineNoise amplitude_noise;  // relative to the amplitude
  LineNoise frequency_noise;  // Hz, fluctuation of the frequency about its mean
};

/// y[n] = gain·e[n] − Σ a_i y[n−i] plus lines. Stored as k_1…k_p of the lattice: stable iff all |k| < 1, so
/// interpolated stable models are stable.
struct ArModel {
  std::vector<double> reflection;  // reflection coefficients k_1 … k_p, each in (−1, 1)
  double gain = 0;                 // standard deviation of the residual; full scale is 1
  double rate = 48000;             // Hz, sampling rate for which the coefficients are valid
  double spindle = 0;              // rad/s, spindle speed of the recorded drill; 0: not known
  // estimated from lines, not given
  bool spindle_estimated = false;
  std::size_t samples = 0;  // fitted samples of the recording; 0: unknown
  std::vector<ModelLine> lines;
  std::string name, method, source, licence, notes;

  std::size_t order() const { return reflection.size(); }
};

/// gain² Π 1/(1 − k²), plus the lines.
double power_of(const ArModel& model);
/// 10·log10 of the noise's one-sided density (1/Hz) at frequencies in Hz.
std::vector<double> spectrum_dB(const ArModel& model, const std::vector<double>& frequencies);

/// First `order` lattice stages with the same power: exactly Burg's fit of this order.
ArModel truncated(const ArModel& model, std::size_t order);
/// Order of least Bayesian information criterion; its own if `samples` is unknown.
std::size_t sufficient_order(const ArModel& model);

/// Throws Error.
ArModel load_model(const std::filesystem::path& file);
/// Returns the model as JSON text.
std::string to_json(const ArModel& model);

}  // namespace typodont::audio
