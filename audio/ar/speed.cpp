#include "audio/ar/speed.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "audio/ar/lines.h"
#include "audio/ar/resample.h"
#include "audio/ar/rotor.h"

namespace typodont::audio {

namespace {
// Shortest and longest sound whose speed is followed, s.
constexpr double kShortest = 0.5, kLongest = 60;
// A line is followed only if it exceeds the neighbouring frequencies by this, dB.
constexpr double kSpeedProminence = 10;
constexpr std::size_t kMaxTried = 6;  // largest number of spectral lines that are tried, strongest first
// Length of the moving averages, s. A spindle has inertia, so its speed changes slowly.
constexpr double kSmoothing = 0.3;
constexpr int kPasses = 3;  // number of successive moving averages; the result is nearly Gaussian

/// Value at the index `at` of the straight line fitted to values[from … from + count).
double extrapolated(const std::vector<double>& values, std::size_t from, std::size_t count, double at) {
  double mean = 0, slope = 0, squares = 0;
  const double middle = static_cast<double>(from) + 0.5 * static_cast<double>(count - 1);
  for (std::size_t i = from; i < from + count; ++i) mean += values[i] / static_cast<double>(count);
  for (std::size_t i = from; i < from + count; ++i) {
    const double away = static_cast<double>(i) - middle;
    slope += away * (values[i] - mean);
    squares += away * away;
  }
  return mean + (squares > 0 ? slope / squares : 0) * (at - middle);
}

/// Smooths with kPasses averages over 2 × `half` + 1 values. Beyond the ends, the values are extrapolated linearly.
void smooth(std::vector<double>& values, std::size_t half) {
  const std::size_t count = values.size(), margin = kPasses * half, fitted = std::min(count, 2 * margin + 1);
  std::vector<double> padded(count + 2 * margin);
  for (std::size_t i = 0; i < margin; ++i) {
    const auto beyond = static_cast<double>(margin - i);
    padded[i] = extrapolated(values, 0, fitted, -beyond);
    padded[margin + count + i] = extrapolated(values, count - fitted, fitted, static_cast<double>(count + i));
  }
  std::copy(values.begin(), values.end(), padded.begin() + static_cast<std::ptrdiff_t>(margin));
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<double> sums(padded.size() + 1, 0.0);
    std::partial_sum(padded.begin(), padded.end(), sums.begin() + 1);
    for (std::size_t i = half; i + half < padded.size(); ++i)
      padded[i] = (sums[i + half + 1] - sums[i - half]) / static_cast<double>(2 * half + 1);
  }
  std::copy_n(padded.begin() + static_cast<std::ptrdiff_t>(margin), count, values.begin());
}
}  // namespace

double SpeedTrack::at(double t) const {
  if (ratio.empty()) return 1;
  const double place = std::clamp(t / step, 0.0, static_cast<double>(ratio.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(place), ratio.size() - 1);
  const auto next = std::min(i + 1, ratio.size() - 1);
  return ratio[i] + (place - static_cast<double>(i)) * (ratio[next] - ratio[i]);
}

double SpeedTrack::range() const {
  if (ratio.empty()) return 0;
  const auto [low, high] = std::minmax_element(ratio.begin(), ratio.end());
  return *high - *low;
}

SpeedTrack speed_of(std::span<const double> x, double rate) {
  const double duration = static_cast<double>(x.size()) / rate;
  if (duration < kShortest || duration > kLongest) return {};
  const auto lines = spectral_lines(x, rate, kSpeedProminence);
  for (std::size_t i = 0; i < std::min(kMaxTried, lines.size()); ++i) {
    LineTrack track = follow_line(x, rate, lines[i].frequency);
    if (!track.steady() || track.frequency < 4 * track.bandwidth) continue;
    smooth(track.deviation, static_cast<std::size_t>(0.5 * kSmoothing * rate / kLineStep));
    // The track lacks both ends of the sound, where the filter has too few samples; the speed is set constant there.
    const auto steps = x.size() / kLineStep;
    const auto missing = (steps - std::min(steps, track.deviation.size())) / 2;
    SpeedTrack speed;
    speed.frequency = track.frequency;
    speed.step = kLineStep / rate;
    speed.ratio.assign(missing, 1 + track.deviation.front() / track.frequency);
    for (const double deviation : track.deviation) speed.ratio.push_back(1 + deviation / track.frequency);
    return speed;
  }
  return {};
}

std::vector<double> at_constant_speed(std::span<const double> x, double rate, const SpeedTrack& speed) {
  if (!speed.known()) return {x.begin(), x.end()};
  const double slowest = *std::min_element(speed.ratio.begin(), speed.ratio.end());
  const InterpolationKernels kernels(1 / slowest);
  const auto margin = static_cast<std::size_t>(kernels.longest_reach());
  std::vector<float> padded(x.size() + 2 * margin, 0.0f);
  std::transform(x.begin(), x.end(), padded.begin() + static_cast<std::ptrdiff_t>(margin),
                 [](double v) { return static_cast<float>(v); });
  std::vector<double> y;
  y.reserve(x.size());
  for (double at = 0; at < static_cast<double>(x.size());) {
    const auto whole = static_cast<std::size_t>(at);
    const double playback = 1 / speed.at(at / rate);
    y.push_back(kernels.read(padded.data() + margin + whole, at - static_cast<double>(whole), playback));
    at += playback;
  }
  return y;
}

}  // namespace typodont::audio
