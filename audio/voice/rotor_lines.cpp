#include "audio/voice/rotor_lines.h"

#include <algorithm>
#include <cmath>

#include "audio/ar/levinson.h"
#include "audio/voice/sine.h"

namespace typodont::audio {

namespace {
// Spectral lines with frequencies above this fraction of the sampling rate are silent.
constexpr double kHighest = 0.45;
constexpr int kWarmUp = 4000;  // number of values discarded until a random process is stationary
}  // namespace

RunningNoise::RunningNoise(const LineNoise& noise, std::uint64_t seed)
    : white_(seed), gain_(noise.gain), a_(step_up(noise.reflection)), past_(2 * a_.size(), 0.0) {
  for (int i = 0; i < kWarmUp; ++i) next();
}

double RunningNoise::next() noexcept {
  double value = gain_ * static_cast<double>(white_.next());
  const std::size_t n = a_.size();
  if (n == 0) return value;
  for (std::size_t i = 0; i < n; ++i) value -= a_[i] * past_[at_ + i];
  at_ = (at_ + n - 1) % n;
  past_[at_] = past_[at_ + n] = value;
  return value;
}

void RotorLines::add(const ModelLine& line, double model_rate, const Factors& factors, std::uint64_t seed) {
  Oscillator o{.frequency = line.frequency,
               .amplitude = static_cast<float>(line.amplitude),
               .factors = factors,
               .amplitude_noise = RunningNoise(line.amplitude_noise, mixed(2 * seed)),
               .frequency_noise = RunningNoise(line.frequency_noise, mixed(2 * seed + 1)),
               .step = std::max(1, static_cast<int>(std::lround(kLineStep * rate_ / model_rate)))};
  o.varies = o.amplitude_noise.next();
  o.wanders = o.frequency_noise.next();
  o.varies_next = o.amplitude_noise.next();
  o.wanders_next = o.frequency_noise.next();
  o.phase = static_cast<std::uint32_t>(mixed(seed + 2));
  oscillators_.push_back(std::move(o));
}

void RotorLines::add(const double* speeds, const float (*gains)[kMost], const bool* active, float* out,
                     int count) noexcept {
  for (Oscillator& o : oscillators_) {
    float power[kMost] = {};
    for (std::size_t t = 0; t < kTissueCount; ++t) {
      if (!active[t]) continue;
      const float factor = o.factors[t];
      for (int i = 0; i < count; ++i) {
        const float gain = gains[t][i] * factor;
        power[i] += gain * gain;
      }
    }
    o.add(speeds, power, out, count, rate_);
  }
}

void RotorLines::Oscillator::add(const double* speeds, const float* power, float* out, int count,
                                 double rate) noexcept {
  // Only the loop over the phase is serial; the other loops vectorise.
  while (count > 0) {
    if (since == step) {
      since = 0;
      varies = varies_next;
      wanders = wanders_next;
      varies_next = amplitude_noise.next();
      wanders_next = frequency_noise.next();
    }
    const int n = std::min(count, step - since);
    // Change of an oscillator's phase per sample and hertz, in units of 2^-32 turns.
    const auto per_hertz = static_cast<float>(0x1p32 / rate);
    const auto highest = static_cast<float>(kHighest * rate);
    const auto hertz = static_cast<float>(frequency + wanders);
    const auto hertz_slope = static_cast<float>((wanders_next - wanders) / step);
    const auto base = static_cast<float>(1 + varies);
    const auto slope = static_cast<float>((varies_next - varies) / step);
    std::int32_t advance[kMost];
    float amplitudes[kMost];
    for (int i = 0; i < n; ++i) {
      const float f =
          std::max(0.0f, hertz + hertz_slope * static_cast<float>(since + i)) * static_cast<float>(speeds[i]);
      advance[i] = static_cast<std::int32_t>(f < highest ? f * per_hertz : 0.0f);
    }
    for (int i = 0; i < n; ++i) {
      const float varied = std::max(0.0f, base + slope * static_cast<float>(since + i));
      const float heard = advance[i] > 0 ? amplitude : 0.0f;
      amplitudes[i] = heard * varied * std::sqrt(power[i]);
    }
    for (int i = 0; i < n; ++i) {
      phase += static_cast<std::uint32_t>(advance[i]);
      advance[i] = static_cast<std::int32_t>(phase);
    }
    for (int i = 0; i < n; ++i) out[i] += amplitudes[i] * sine_of_half_turns(static_cast<float>(advance[i]) * 0x1p-31f);
    speeds += n;
    power += n;
    out += n;
    count -= n;
    since += n;
  }
}

}  // namespace typodont::audio
