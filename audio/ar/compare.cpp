#include "audio/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "audio/ar/lines.h"
#include "audio/ar/rotor.h"
#include "audio/ar/spectrum.h"
#include "audio/ar/speed.h"
#include "audio/sound_file.h"
#include "engine/base/error.h"

namespace typodont::audio {

namespace {

constexpr double kWindow = 1024.0 / 48000;  // s, length of the analysis window
// Distance between the compared frequencies, Hz.
constexpr double kGrid = 46.875;

struct Analysed {
  SoundMeasure measure;
  std::vector<double> power;  // power density at the frequencies kGrid, 2 kGrid, …
};

Analysed analyse(const std::filesystem::path& file, const Recording& recording, double up_to,
                 const CompareOptions& options) {
  auto x = recording.mono();
  Analysed result;
  SoundMeasure& m = result.measure;
  m.rate = recording.rate;
  m.duration = static_cast<double>(x.size()) / m.rate;
  double power = 0, peak = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i])) throw Error(file.string(), fmt::format("sample {}", i), "not a number", "finite samples");
    power += x[i] * x[i];
    peak = std::max(peak, std::abs(x[i]));
  }
  m.level_dB = 10 * std::log10(power / static_cast<double>(x.size()) + 1e-30);
  m.peak_dB = 20 * std::log10(peak + 1e-15);

  if (options.constant_speed) x = at_constant_speed(x, m.rate, speed_of(x, m.rate));
  const auto points = static_cast<std::size_t>(2 * std::lround(kWindow * m.rate / 2));
  const auto density = welch(x, points, m.rate);
  double moment = 0, sum = 0;
  for (double f = kGrid; f <= up_to; f += kGrid) {
    const double at = f / m.rate * static_cast<double>(points);
    const auto i = std::min(static_cast<std::size_t>(at), density.size() - 2);
    const double blend = at - static_cast<double>(i);
    const double value =
        std::exp((1 - blend) * std::log(density[i] + 1e-30) + blend * std::log(density[i + 1] + 1e-30));
    result.power.push_back(value);
    moment += f * value;
    sum += value;
  }
  m.centroid = sum > 0 ? moment / sum : 0;
  const auto lines = spectral_lines(x, m.rate);
  for (std::size_t i = 0; i < lines.size() && i < 5; ++i) {
    const LineTrack track = follow_line(x, m.rate, lines[i].frequency);
    m.tones.push_back(track.steady() ? track.frequency : lines[i].frequency);
    m.tone_variation.push_back(track.variation());
  }
  for (const double line : options.lines) m.line_variation.push_back(follow_line(x, m.rate, line).variation());
  m.rotor = estimated_rotor_frequency(x, m.rate);
  return result;
}

}  // namespace

Comparison compare_sounds(const std::filesystem::path& file_a, const std::filesystem::path& file_b,
                          const CompareOptions& options) {
  Comparison result;
  const Recording sound_a = read_recording(file_a), sound_b = read_recording(file_b);
  result.up_to = std::min(options.up_to, 0.45 * std::min(sound_a.rate, sound_b.rate));
  const Analysed a = analyse(file_a, sound_a, result.up_to, options);
  const Analysed b = analyse(file_b, sound_b, result.up_to, options);
  result.a = a.measure;
  result.b = b.measure;
  result.level_difference_dB = result.b.level_dB - result.a.level_dB;
  // Skips the first frequency, kGrid, which the window cannot resolve.
  const std::span<const double> pa(a.power.begin() + 1, a.power.end()), pb(b.power.begin() + 1, b.power.end());
  result.distance_dB = log_spectral_distance(pa, pb);
  result.itakura_saito = itakura_saito(pa, pb);
  double mean = 0;
  for (std::size_t i = 0; i < pa.size(); ++i) mean += 10 * std::log10((pa[i] + 1e-30) / (pb[i] + 1e-30));
  mean /= static_cast<double>(pa.size());
  result.shape_distance_dB = std::sqrt(std::max(0.0, result.distance_dB * result.distance_dB - mean * mean));
  if (!result.a.tones.empty() && !result.b.tones.empty()) result.tone_ratio = result.b.tones[0] / result.a.tones[0];
  return result;
}

}  // namespace typodont::audio
