#include "audio/spectrogram.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "audio/ar/spectrum.h"

namespace typodont::audio {

namespace {
// Smallest power density, full scale² per Hz (-200 dB).
constexpr double kMinPower = 1e-20;
}  // namespace

Spectrogram spectrogram(std::span<const double> sound, double rate, std::size_t frames, double window) {
  const std::size_t n = std::bit_ceil(static_cast<std::size_t>(std::max(2.0, window * rate)));
  Spectrogram result{rate / static_cast<double>(n), frames, n / 2 + 1, {}};
  result.dB.reserve(frames * result.bins);
  for (std::size_t i = 0; i < frames; ++i) {
    const std::size_t begins = i * sound.size() / frames, ends = (i + 1) * sound.size() / frames;
    const std::size_t length = std::min(sound.size(), std::max(ends - begins, n));
    const std::size_t middle = (begins + ends) / 2;
    const std::size_t from = std::min(middle - std::min(middle, length / 2), sound.size() - length);
    for (const double power : welch(sound.subspan(from, length), n, rate))
      result.dB.push_back(static_cast<float>(10 * std::log10(power + kMinPower)));
  }
  return result;
}

}  // namespace typodont::audio
