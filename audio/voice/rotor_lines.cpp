#include "audio/voice/rotor_lines.h"

#include <algorithm>
#include <cmath>

#include "audio/ar/levinson.h"
#include "audio/voice/sine.h"

namespace typodont::audio {

namespace {
constexpr int kWarmUp = 4000;  // number of values after which a process that starts from zero is stationary
}

RunningNoise::RunningNoise(const LineNoise& noise, std::uint64_t seed)
    : white_(seed), gain_(noise.gain), a_(step_up(noise.reflection)), past_(a_.size(), 0.0) {
  for (int i = 0; i < kWarmUp; ++i) next();
}

double RunningNoise::next() noexcept {
  double value = gain_ * static_cast<double>(white_.next());
  const std::size_t n = a_.size();
  for (std::size_t i = 0; i < n; ++i) value -= a_[i] * past_[(at_ + i) % n];
  if (n > 0) {
    at_ = (at_ + n - 1) % n;
    past_[at_] = value;
  }
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
  o.phase = static_cast<double>(mixed(seed + 2) >> 11) * 0x1p-53;  // random phase in [0, 1)
  oscillators_.push_back(std::move(o));
}

float RotorLines::Oscillator::next(double speed, float power, double rate) noexcept {
  if (left == 0) {
    left = step;
    varies_step = (amplitude_noise.next() - varies) / step;
    wanders_step = (frequency_noise.next() - wanders) / step;
  }
  --left;
  varies += varies_step;
  wanders += wanders_step;
  const double turns = std::max(0.0, frequency + wanders) * speed / rate;
  phase += turns;
  phase -= std::floor(phase);
  if (turns >= 0.45 || power == 0) return 0;
  return amplitude * std::max(0.0f, 1 + static_cast<float>(varies)) * std::sqrt(power) * sine_of_turns(phase);
}

}  // namespace typodont::audio
