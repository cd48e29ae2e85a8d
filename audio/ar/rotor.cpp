#include "audio/ar/rotor.h"

#include <algorithm>
#include <cmath>

#include "audio/ar/spectrum.h"
#include "engine/base/quantile.h"

namespace typodont::audio {

std::vector<SpectralLine> spectral_lines(std::span<const double> x, double rate, double at_least_dB, double window) {
  const auto points = static_cast<std::size_t>(2 * std::lround(rate / 2 * window));
  const auto power = welch(x, points, rate);
  const double bin = rate / static_cast<double>(points);
  const auto reach = static_cast<std::ptrdiff_t>(std::lround(400 / bin));
  const auto size = static_cast<std::ptrdiff_t>(power.size());
  std::vector<SpectralLine> lines;
  std::vector<double> around;
  for (std::ptrdiff_t i = 4; i + 4 < size; ++i) {
    const auto at = power.begin() + i;
    if (*std::max_element(at - 3, at + 4) > *at) continue;
    around.assign(power.begin() + std::max<std::ptrdiff_t>(1, i - reach), power.begin() + std::min(size, i + reach));
    const double prominence = 10 * std::log10((*at + 1e-30) / (nth(around, around.size() / 2) + 1e-30));
    if (prominence < at_least_dB) continue;
    // Position of the peak in bins, from a parabola through the logarithms of the power in three bins.
    const double l = std::log(at[-1] + 1e-30), c = std::log(at[0] + 1e-30), r = std::log(at[1] + 1e-30);
    const double curve = l - 2 * c + r;
    const double shift = curve < 0 ? std::clamp(0.5 * (l - r) / curve, -0.5, 0.5) : 0.0;
    lines.push_back({(static_cast<double>(i) + shift) * bin, prominence, 10 * std::log10(*at + 1e-30)});
  }
  std::sort(lines.begin(), lines.end(), [](const auto& a, const auto& b) { return a.level_dB > b.level_dB; });
  return lines;
}

double estimated_rotor_frequency(std::span<const double> x, double rate) {
  const auto lines = spectral_lines(x, rate, 6);
  const auto prominence_near = [&](double f) {
    double best = 0;
    for (const auto& line : lines) {
      if (std::abs(line.frequency - f) < std::max(15.0, 0.006 * f)) best = std::max(best, line.prominence);
    }
    return best;
  };
  // The score of a harmonic series must exceed the initial best_score, dB.
  double best = 0, best_score = 12;
  for (const auto& line : lines) {
    for (int divisor = 1; divisor <= 3; ++divisor) {
      const double f = line.frequency / divisor;
      if (f < 250 || f > 8000) continue;
      // Each existing harmonic adds its prominence − 5 dB. Each missing harmonic below an existing one subtracts 5 dB.
      double score = 0, missing = 0;
      int present = 0;
      for (int harmonic = 1; harmonic <= 8 && harmonic * f < 0.45 * rate; ++harmonic) {
        const double prominence = std::min(prominence_near(harmonic * f), 25.0);
        if (prominence > 0) {
          score += prominence - 5 - missing;
          missing = 0;
          ++present;
        } else {
          missing += 5;
        }
      }
      if (present >= 2 && score > best_score) {  // a single line is not enough for a harmonic series
        best_score = score;
        best = f;
      }
    }
  }
  return best;
}

}  // namespace typodont::audio
