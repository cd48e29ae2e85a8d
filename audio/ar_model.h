// An autoregressive model: white noise that is filtered to the spectrum of the drill. Stored as JSON.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace typodont::audio {

/// Slow random process with one value per kLineStep samples. Without coefficients and gain, the process is zero.
struct LineNoise {
  std::vector<double> reflection;  // reflection coefficients k_1 … k_p, each in (−1, 1)
  double gain = 0;                 // standard deviation of the process's residual

  double deviation() const;  // returns the standard deviation of the process
};
inline constexpr int kLineStep = 64;

/// A spectral line: a sinusoid whose amplitude and frequency vary slowly. Filtered noise instead of sinusoids would
/// hiss, not whistle.
struct ModelLine {
  double frequency = 0;       // Hz, mean frequency of the spectral line
  double amplitude = 0;       // mean amplitude; full scale is 1
  LineNoise amplitude_noise;  // variation of the amplitude, relative to its mean
  LineNoise frequency_noise;  // Hz, fluctuation of the frequency about its mean
};

/// The model y[n] = gain·e[n] − Σ a_i y[n−i] (e: white noise), plus spectral lines. Stored as reflection coefficients
/// of the lattice filter, which is stable if and only if all |k| < 1, so interpolated models are stable too.
struct ArModel {
  std::vector<double> reflection;  // reflection coefficients k_1 … k_p, each in (−1, 1)
  double gain = 0;                 // standard deviation of the input noise; full scale is 1
  double rate = 48000;             // Hz, sampling rate for which the coefficients are valid
  double spindle = 0;              // rad/s, spindle speed of the recorded drill; 0: not known
  // true: `spindle` was estimated from spectral lines, not given.
  bool spindle_estimated = false;
  std::size_t samples = 0;  // number of fitted samples of the recording; 0: unknown
  std::vector<ModelLine> lines;
  std::string name, method, source, licence, notes;

  std::size_t order() const { return reflection.size(); }
};

/// Mean power of the sound: gain² Π 1/(1 − k²) (k: reflection coefficients), plus that of the spectral lines.
double power_of(const ArModel& model);
/// Spectrum of the noise in dB: 10·log10 of the one-sided density (1/Hz) at frequencies in Hz.
std::vector<double> spectrum_dB(const ArModel& model, const std::vector<double>& frequencies);

/// Model of the first `order` lattice stages with the same power. This is exactly Burg's fit of that order.
ArModel truncated(const ArModel& model, std::size_t order);
/// The order with the smallest Bayesian information criterion. If model.samples is unknown: the model's own order.
std::size_t sufficient_order(const ArModel& model);

/// Reads a model. Throws Error.
ArModel load_model(const std::filesystem::path& file);
/// Returns the model as JSON text.
std::string to_json(const ArModel& model);

}  // namespace typodont::audio
