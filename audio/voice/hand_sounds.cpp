#include "audio/voice/hand_sounds.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"

namespace typodont::audio {

namespace {

constexpr double kAsperity = 20e-6;  // m, distance of the bumps that a tip meets on a tooth

/// Frequency in Hz of the first mode, its decay time in s, and its strength. Harder tissue sounds higher, longer and
/// louder. The other two modes have 1.58 and 2.24 times the frequency of the first mode (2.76 and 5.4 times for a
/// free bar; for a held crown the modes are closer). The values were chosen by ear; they are not measured.
struct Ring {
  double frequency, decay, weight;
};
constexpr std::array<Ring, kTissueCount> kRings = {{
    {3000, 0.0005, 0.0},  // air
    {5200, 0.0060, 1.0},  // enamel
    {3400, 0.0035, 0.8},  // dentin
    {1500, 0.0015, 0.4},  // caries
    {500, 0.0010, 0.1},   // pulp
    {2600, 0.0040, 0.8},  // cortical bone
    {1400, 0.0020, 0.5},  // cancellous bone
    {300, 0.0008, 0.1},   // gingiva
    {4400, 0.0080, 1.0},  // amalgam
    {3600, 0.0030, 0.8},  // composite
}};
constexpr double kModeRatios[] = {1.0, 1.58, 2.24};

}  // namespace

ModalBank::ModalBank(double sample_rate) {
  for (std::size_t t = 0; t < modes_.size(); ++t) {
    for (std::size_t m = 0; m < kModes; ++m) {
      const double frequency = std::min(kRings[t].frequency * kModeRatios[m], 0.45 * sample_rate);
      const double radius = std::exp(-kModeRatios[m] / (kRings[t].decay * sample_rate));
      Mode& mode = modes_[t][m];
      mode.turn_re = static_cast<float>(radius * std::cos(2 * kPi * frequency / sample_rate));
      mode.turn_im = static_cast<float>(radius * std::sin(2 * kPi * frequency / sample_rate));
      mode.weight = static_cast<float>(kRings[t].weight / kModeRatios[m]);
    }
  }
}

void ModalBank::strike(Tissue tissue, float strength) noexcept {
  const auto t = static_cast<std::size_t>(tissue);
  for (Mode& mode : modes_[t]) mode.re += strength * mode.weight;
  ringing_[t] = true;
  silent_ = false;
}

float ModalBank::next() noexcept {
  if (silent_) return 0;
  float sum = 0, energy = 0;
  const bool check = until_check_-- <= 0;
  if (check) until_check_ = 255;
  silent_ = true;
  for (std::size_t t = 0; t < modes_.size(); ++t) {
    if (!ringing_[t]) continue;
    energy = 0;
    for (Mode& mode : modes_[t]) {
      sum += mode.re;
      const float re = mode.re * mode.turn_re - mode.im * mode.turn_im;
      mode.im = mode.re * mode.turn_im + mode.im * mode.turn_re;
      mode.re = re;
      energy += mode.re * mode.re + mode.im * mode.im;
    }
    if (check && energy < 1e-14f) {  // below -140 dB the sound has ended
      ringing_[t] = false;
      for (Mode& mode : modes_[t]) mode.re = mode.im = 0;
    }
    silent_ = silent_ && !ringing_[t];
  }
  return sum;
}

Scrape::Scrape(double sample_rate, std::uint64_t seed)
    : noise_(seed), per_radian_(static_cast<float>(2 * kPi / sample_rate)) {}

float Scrape::next(float slip, float level) noexcept {
  // Two one-pole low-passes, one octave above and below the rate of bumps; their difference is a band-pass.
  const float rate = slip / static_cast<float>(kAsperity);
  const float upper = std::min(2 * rate * per_radian_, 0.9f), lower = std::min(0.5f * rate * per_radian_, 0.5f);
  const float white = noise_.next();
  high_ += upper * (white - high_);
  low_ += lower * (high_ - low_);
  return level * (high_ - low_);
}

Suction::Suction(double sample_rate, std::uint64_t seed) : noise_(seed), slow_(mixed(seed)) {
  const double radius = std::exp(-kPi * 900 / sample_rate);  // bandwidth 900 Hz around 1.4 kHz
  a1_ = static_cast<float>(-2 * radius * std::cos(2 * kPi * 1400 / sample_rate));
  a2_ = static_cast<float>(radius * radius);
  gain_ = static_cast<float>(1 - radius);
  slow_gain_ = static_cast<float>(2 * kPi * 5 / sample_rate);  // modulation at 5 Hz (gurgling)
}

float Suction::next(float level) noexcept {
  const float white = noise_.next();
  const float y = gain_ * white - a1_ * y1_ - a2_ * y2_;
  y2_ = y1_;
  y1_ = y;
  gurgle_ += slow_gain_ * (slow_.next() - gurgle_);
  const float swell = std::clamp(1.0f + 20.0f * gurgle_, 0.3f, 2.0f);
  return level * swell * (y + 0.05f * white);
}

}  // namespace typodont::audio
