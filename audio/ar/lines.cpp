#include "audio/ar/lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numeric>
#include <utility>

#include "audio/ar/estimate.h"
#include "audio/ar/noise.h"
#include "audio/ar/rotor.h"
#include "audio/ar/spectrum.h"
#include "engine/base/quantile.h"
#include "engine/base/units.h"

namespace typodont::audio {

namespace {

constexpr double kProminence = 10;              // dB, smallest prominence of a spectral line
constexpr double kFineWindow = 8192.0 / 48000;  // s, window in which lines are searched
constexpr std::size_t kMaxFound = 10;
constexpr std::size_t kNoiseOrder = 16;  // poles of the models of amplitude and frequency deviations
// s; changes of a line's frequency that are slower than this count as changes of the spindle's speed.
constexpr double kDrift = 1;
constexpr double kLongestTrack = 60;  // s, longest part of a recording in which a line is followed
// The noise beside a line is measured in bands of this width, Hz.
constexpr double kFloorReach = 100;
// Largest amplitude variance caused by noise, relative to the squared mean amplitude, in a band that can be used.
constexpr double kWeakNoise = 0.02;
// Half widths of the bands around a line, in the order in which they are tried, Hz.
constexpr std::array kBandwidths = {80.0, 40.0, 20.0};

using Complex = std::complex<double>;

/// Smooths with three moving averages: nearly Gaussian, without delay.
void smooth(std::vector<Complex>& z, std::size_t half) {
  const std::size_t n = z.size();
  std::vector<Complex> sums(n + 1);
  for (int pass = 0; pass < 3; ++pass) {
    for (std::size_t i = 0; i < n; ++i) sums[i + 1] = sums[i] + z[i];
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t from = i > half ? i - half : 0, to = std::min(n, i + half + 1);
      z[i] = (sums[to] - sums[from]) / static_cast<double>(to - from);
    }
  }
}

/// Half length, in samples, of the moving averages whose gain is -3 dB at `bandwidth` (Hz).
std::size_t half_length(double bandwidth, double rate) {
  return static_cast<std::size_t>(std::lround(0.5 * 0.26 * rate / bandwidth));
}

/// Complex oscillation. Multiplication by this oscillation shifts `frequency` to 0 Hz.
std::vector<Complex> shift_of(double frequency, double rate, std::size_t count) {
  std::vector<Complex> shift(count);
  const double turns = frequency / rate;
  for (std::size_t i = 0; i < count; ++i) {
    const double phase = turns * static_cast<double>(i);
    shift[i] = std::polar(1.0, -2 * kPi * (phase - std::floor(phase)));
  }
  return shift;
}

/// Complex amplitude over time of the sinusoid that `shift` moves to 0 Hz.
std::vector<Complex> band_about(std::span<const double> x, std::span<const Complex> shift, double rate,
                                double bandwidth) {
  std::vector<Complex> z(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) z[i] = 2 * x[i] * shift[i];
  smooth(z, half_length(bandwidth, rate));
  return z;
}

/// Replaces the band around `frequency` by noise with the one-sided density `floor` (1/Hz). Works piece by piece to
/// save memory.
void replace_band(std::vector<double>& x, double rate, double frequency, double bandwidth, double floor) {
  constexpr std::size_t kPiece = 1 << 20;
  // (1 - H) x, with the band-pass H around `frequency`, lacks power in this band. Noise through a filter of twice the
  // width replaces this power: both power responses add up to 1 within 0.6 dB.
  const double noise_bandwidth = 2 * bandwidth;
  const std::size_t margin = 3 * half_length(bandwidth, rate) + 3, n = x.size();
  std::vector<double> noise(n);
  GaussianNoise white(1);
  const double level = std::sqrt(floor * rate / 2);
  for (double& v : noise) v = level * static_cast<double>(white.next());
  const std::vector<double> before = x;
  const std::vector<Complex> shift = shift_of(frequency, rate, std::min(n, kPiece + 2 * margin));
  for (std::size_t at = 0; at < n; at += kPiece) {
    const std::size_t from = at > margin ? at - margin : 0, to = std::min(n, at + kPiece + margin);
    const auto taken = band_about(std::span(before).subspan(from, to - from), shift, rate, bandwidth);
    const auto given = band_about(std::span(noise).subspan(from, to - from), shift, rate, noise_bandwidth);
    for (std::size_t i = at; i < std::min(n, at + kPiece); ++i)
      x[i] += ((given[i - from] - taken[i - from]) * std::conj(shift[i - from])).real();
  }
}

/// Amplitude and frequency of a line over time. `z`: complex amplitude, without its ends, where averages are one-sided.
LineTrack track_of(std::span<const Complex> z, double rate, double frequency, double bandwidth) {
  LineTrack track;
  track.bandwidth = bandwidth;
  for (std::size_t at = 0; at + kLineStep < z.size(); at += kLineStep) {
    double amplitude = 0;
    Complex turned = 0;  // Σ z[i+1] · conj(z[i]); its angle: mean phase step
    for (std::size_t i = at; i < at + kLineStep; ++i) {
      amplitude += std::abs(z[i]);
      turned += z[i + 1] * std::conj(z[i]);
    }
    track.amplitude.push_back(amplitude / kLineStep);
    track.deviation.push_back(std::arg(turned) / (2 * kPi) * rate);
  }
  if (track.deviation.empty()) return track;
  const double mean = std::accumulate(track.deviation.begin(), track.deviation.end(), 0.0) /
                      static_cast<double>(track.deviation.size());
  track.frequency = frequency + mean;
  for (double& deviation : track.deviation) deviation -= mean;
  return track;
}

double root_mean_square(const std::vector<double>& values) {
  return std::sqrt(std::inner_product(values.begin(), values.end(), values.begin(), 0.0) /
                   static_cast<double>(std::max<std::size_t>(1, values.size())));
}

/// Subtracts the mean over the surrounding kDrift seconds.
std::vector<double> without_drift(const std::vector<double>& values, double rate) {
  const auto half = static_cast<std::ptrdiff_t>(0.5 * kDrift * rate / kLineStep);
  const auto count = static_cast<std::ptrdiff_t>(values.size());
  std::vector<double> sums(values.size() + 1, 0.0), result = values;
  std::partial_sum(values.begin(), values.end(), sums.begin() + 1);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    // The averaged range is symmetric about i, so subtracting its mean also removes a linear drift.
    const auto reach = std::min({half, i, count - 1 - i});
    const double around = sums[static_cast<std::size_t>(i + reach + 1)] - sums[static_cast<std::size_t>(i - reach)];
    result[static_cast<std::size_t>(i)] -= around / static_cast<double>(2 * reach + 1);
  }
  return result;
}

LineNoise noise_of(std::vector<double> values) {
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  for (double& value : values) value -= mean;
  const std::size_t order = std::min(kNoiseOrder, values.size() / 10);
  const Estimate estimate = burg(values, order);
  LineNoise noise;
  noise.gain = std::sqrt(std::max(0.0, estimate.variance));
  if (noise.gain > 0) noise.reflection = estimate.reflection;
  for (double& k : noise.reflection) k = std::clamp(k, -0.9999, 0.9999);
  return noise;
}

/// Power density (1/Hz) beside a line: median in the bands next to the line's band.
double floor_about(const std::vector<double>& power, double bin, double frequency, double bandwidth) {
  const double nearest = std::max(1.2 * bandwidth, 3 * bin);
  std::vector<double> around;
  for (std::size_t i = 1; i < power.size(); ++i) {
    const double away = std::abs(static_cast<double>(i) * bin - frequency);
    if (away >= nearest && away <= nearest + kFloorReach) around.push_back(power[i]);
  }
  return around.empty() ? 0 : nth(around, around.size() / 2);
}

/// Returns the noise of a line's amplitude, with its variance reduced by `variance`.
LineNoise without(LineNoise noise, double variance) {
  const double all = noise.deviation() * noise.deviation();
  noise.gain = all > variance ? noise.gain * std::sqrt(1 - variance / all) : 0.0;
  if (noise.gain == 0) noise.reflection.clear();
  return noise;
}

}  // namespace

double LineTrack::mean_amplitude() const {
  if (amplitude.empty()) return 0;
  return std::accumulate(amplitude.begin(), amplitude.end(), 0.0) / static_cast<double>(amplitude.size());
}

double LineTrack::amplitude_variance_of_noise() const {
  // Power of the noise in the line's band: `floor` · ∫|H|² df, where |H|² = 2^(−(f/bandwidth)²).
  const double mean = mean_amplitude();
  return mean > 0 ? floor * std::sqrt(kPi / std::log(2.0)) * bandwidth / (mean * mean) : 0.0;
}

double LineTrack::frequency_variance_of_noise() const {
  return amplitude_variance_of_noise() * bandwidth * bandwidth / (2 * std::log(2.0));
}

double LineTrack::variation() const {
  const double mean = mean_amplitude();
  if (!(mean > 0)) return 0;
  double square = 0;
  for (const double a : amplitude) square += (a - mean) * (a - mean);
  return std::sqrt(square / static_cast<double>(amplitude.size())) / mean;
}

double LineTrack::own_variation() const {
  const double all = variation();
  return std::sqrt(std::max(0.0, all * all - amplitude_variance_of_noise()));
}

LineTrack follow_line(std::span<const double> x, double rate, double frequency) {
  if (static_cast<double>(x.size()) < 0.2 * rate) return {};
  const auto most = static_cast<std::size_t>(kLongestTrack * rate);
  if (x.size() > most) x = x.subspan((x.size() - most) / 2, most);
  const auto points = static_cast<std::size_t>(2 * std::lround(rate / 2 * kLineWindow));
  const auto power = welch(x, points, rate);
  const std::vector<Complex> shift = shift_of(frequency, rate, x.size());
  LineTrack best;
  for (const double bandwidth : kBandwidths) {
    const auto z = band_about(x, shift, rate, bandwidth);
    const std::size_t edge = std::min(3 * half_length(bandwidth, rate), x.size() / 4);
    LineTrack track = track_of(std::span(z).subspan(edge, x.size() - 2 * edge), rate, frequency, bandwidth);
    track.floor = floor_about(power, rate / static_cast<double>(points), frequency, bandwidth);
    if (track.amplitude_variance_of_noise() < kWeakNoise) return track;
    if (best.amplitude.empty() || track.variation() < best.variation()) best = std::move(track);
  }
  return best;
}

std::vector<TakenLine> take_lines(std::vector<double>& x, double rate) {
  std::vector<TakenLine> lines;
  // Centre frequency and full width of each band that was already tried, Hz.
  std::vector<std::pair<double, double>> tried;
  for (const SpectralLine& found : spectral_lines(x, rate, kProminence, kFineWindow)) {
    if (lines.size() == kMaxFound) break;
    // A line whose frequency varies has several peaks. Peaks in a band that was already tried are skipped.
    const auto near = [&](const auto& other) { return std::abs(other.first - found.frequency) < other.second; };
    if (found.frequency < kBandwidths.front() || std::any_of(tried.begin(), tried.end(), near)) continue;
    const LineTrack track = follow_line(x, rate, found.frequency);
    tried.emplace_back(found.frequency, 2 * track.bandwidth);
    if (!track.steady() || std::abs(track.frequency - found.frequency) > track.bandwidth) continue;
    ModelLine line;
    line.frequency = track.frequency;
    line.amplitude = track.mean_amplitude();
    std::vector<double> relative;
    for (const double a : track.amplitude) relative.push_back(a / line.amplitude - 1);
    // The noise near the line stays in the noise model, so its variance is subtracted here.
    line.amplitude_noise = without(noise_of(relative), track.amplitude_variance_of_noise());
    line.frequency_noise = without(noise_of(without_drift(track.deviation, rate)), track.frequency_variance_of_noise());
    replace_band(x, rate, line.frequency, track.bandwidth, track.floor);
    lines.push_back({std::move(line), root_mean_square(track.deviation), track.variation()});
  }
  return lines;
}

std::vector<double> lines_through_window(const std::vector<TakenLine>& lines, std::size_t n, double rate) {
  std::vector<double> power(n / 2 + 1);
  const double bin = rate / static_cast<double>(n);
  for (const auto& [line, spread, variation] : lines) {
    const double varies = line.amplitude_noise.deviation();
    const double square = line.amplitude * line.amplitude * (1 + varies * varies);
    // The line's frequency is normally distributed: adds kPoints weighted sinusoids within ±2 σ, with a Hann window.
    constexpr int kPoints = 9;
    double weights = 0;
    for (int k = 0; k < kPoints; ++k) weights += std::exp(-0.125 * (k - 4) * (k - 4));
    for (int k = 0; k < kPoints; ++k) {
      const double weight = std::exp(-0.125 * (k - 4) * (k - 4)) / weights;
      const double frequency = line.frequency + 0.5 * (k - 4) * spread;
      for (std::size_t i = 0; i < power.size(); ++i) {
        const double away = static_cast<double>(i) - frequency / bin;  // bins, distance from the line's frequency
        if (std::abs(away) > 64) continue;
        const double sinc = std::abs(away) < 1e-6 ? 1 : std::sin(kPi * away) / (kPi * away);
        const double main = std::abs(std::abs(away) - 1) < 1e-6 ? 0.5 : sinc / (1 - away * away);
        power[i] += weight * square * static_cast<double>(n) * main * main / (3 * rate);
      }
    }
  }
  return power;
}

}  // namespace typodont::audio
