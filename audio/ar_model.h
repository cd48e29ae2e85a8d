// An autoregressive model of a sound: a filter that turns white noise into noise with the drill's spectrum. Plain data;
// the file format is JSON.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace typodont::audio {

/// A slow autoregressive process that has one value per kLineStep samples of the model's rate. Without coefficients and
/// gain it is constantly zero.
struct LineNoise {
  std::vector<double> reflection;  // reflection coefficients k_1 … k_p, each in (−1, 1)
  double gain = 0;                 // standard deviation of the process's residual

  double deviation() const;  // returns the standard deviation of the process
};
inline constexpr int kLineStep = 64;

/// A spectral line of a rotor: a sinusoid whose amplitude and frequency vary slowly about their means. A turbine's
/// whistle is such a line. Filtered noise with the same spectrum would hiss instead.
struct ModelLine {
  double frequency = 0;       // Hz, mean frequency of the spectral line
  double amplitude = 0;       // mean amplitude; full scale is 1
  LineNoise amplitude_noise;  // fluctuation of the amplitude, as a ratio to the mean amplitude
  LineNoise frequency_noise;  // Hz, fluctuation of the frequency about its mean
};

/// A model of noise: y[n] = gain·e[n] − Σ a_i y[n−i], where y is the sound and e is white noise of unit variance. The
/// model stores the reflection coefficients k_1…k_p of the lattice form instead of the coefficients a_i. The filter is
/// stable if and only if all k lie in (−1, 1), so interpolating the k of two stable models gives a stable model. The
/// rotor's spectral lines are added to y.
struct ArModel {
  std::vector<double> reflection;  // reflection coefficients k_1 … k_p, each in (−1, 1)
  double gain = 0;                 // standard deviation of the residual; full scale is 1
  double rate = 48000;             // Hz, sampling rate for which the coefficients are valid
  double spindle = 0;              // rad/s, spindle speed of the recorded drill; 0: not known
  // true if the spindle's speed was estimated from the spectral lines, not given by the user
  bool spindle_estimated = false;
  std::size_t samples = 0;  // number of samples of the recording to which the model was fitted; 0: unknown
  std::vector<ModelLine> lines;
  std::string name, method, source, licence, notes;

  std::size_t order() const { return reflection.size(); }
};

/// Returns the mean power of the model's output: gain² Π 1/(1 − k²) of the noise, plus the power of the spectral lines.
double power_of(const ArModel& model);
/// Returns 10·log10 of the one-sided power density (1/Hz) of the noise, without the spectral lines, at the frequencies
/// given in Hz.
std::vector<double> spectrum_dB(const ArModel& model, const std::vector<double>& frequencies);

/// Returns the model reduced to its first `order` lattice stages, with the same power. For Burg's method this is
/// exactly the result of a fit of this order.
ArModel truncated(const ArModel& model, std::size_t order);
/// Returns the order with the least Bayesian information criterion, or the model's own order if `samples` is unknown.
std::size_t sufficient_order(const ArModel& model);

/// Reads and checks a model file. Throws Error with the file, the key, the value that was found, and the value that was
/// expected.
ArModel load_model(const std::filesystem::path& file);
/// Returns the model as JSON text.
std::string to_json(const ArModel& model);

}  // namespace typodont::audio
