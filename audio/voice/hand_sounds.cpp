#include "audio/voice/hand_sounds.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"

namespace typodont::audio {

namespace {

// Sound of the spray: the jet hisses around 5 kHz, the droplets crackle.
constexpr double kJetFrom = 2500, kJetTo = 9000;  // Hz, limits of the band in which the jet hisses
constexpr double kDropletsPerSecond = 500;
constexpr float kDropletPower = 0.25f;  // fraction of the spray's power that comes from the droplets

// Amplitude of the suction's white noise outside its resonance, relative to the noise that excites the resonance.
constexpr float kSuctionHiss = 1;

constexpr double kAsperity = 20e-6;  // m, distance between the asperities of a tooth's surface

/// Lowest vibration mode of a tissue: frequency (Hz), decay time (s), strength. Two other modes have 1.58 and 2.24
/// times its frequency. Chosen by ear: harder tissue sounds higher, longer and louder.
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
// Cut-off frequency of the scraping sound divided by the frequency of the tissue's lowest mode.
constexpr double kScrapeDamping = 1;
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
    if (check && energy < 1e-14f) {  // below -140 dB, the mode's sound has ended
      ringing_[t] = false;
      for (Mode& mode : modes_[t]) mode.re = mode.im = 0;
    }
    silent_ = silent_ && !ringing_[t];
  }
  return sum;
}

Scrape::Scrape(double sample_rate, std::uint64_t seed)
    : noise_(seed), per_radian_(static_cast<float>(2 * kPi / sample_rate)) {
  for (std::size_t t = 0; t < damping_.size(); ++t) {
    damping_[t] = static_cast<float>(1 - std::exp(-2 * kPi * kScrapeDamping * kRings[t].frequency / sample_rate));
  }
}

float Scrape::next(float slip, float level, Tissue tissue) noexcept {
  // `rate`: asperities per second. Low-pass filters form a band-pass from rate / 2 (one pole) to 2 · rate (two poles).
  const float rate = slip / static_cast<float>(kAsperity);
  const float upper = std::min(2 * rate * per_radian_, 0.9f), lower = std::min(0.5f * rate * per_radian_, 0.5f);
  high_[0] += upper * (noise_.next() - high_[0]);
  high_[1] += upper * (high_[0] - high_[1]);
  low_ += lower * (high_[1] - low_);
  const float damping = damping_[static_cast<std::size_t>(tissue)];
  damped_[0] += damping * (high_[1] - low_ - damped_[0]);
  damped_[1] += damping * (damped_[0] - damped_[1]);
  return level * damped_[1];
}

Suction::Suction(double sample_rate, std::uint64_t seed) : noise_(seed), slow_(mixed(seed)) {
  // Poles of the suction's resonance at 1.4 kHz with a width of 900 Hz.
  const double radius = std::exp(-kPi * 900 / sample_rate);
  a1_ = static_cast<float>(-2 * radius * std::cos(2 * kPi * 1400 / sample_rate));
  a2_ = static_cast<float>(radius * radius);
  slow_gain_ = static_cast<float>(2 * kPi * 5 / sample_rate);  // modulation at 5 Hz (gurgling)
  float energy = 0;  // energy of the impulse response, which is the gain for white noise
  for (int i = 0; i < 4096; ++i) {
    const float v = filtered(i == 0 ? 1.0f : 0.0f);
    energy += v * v;
  }
  y1_ = y2_ = 0;
  gain_ = 1 / std::sqrt(energy);
}

float Suction::filtered(float white) noexcept {
  const float y = white - a1_ * y1_ - a2_ * y2_;
  y2_ = y1_;
  y1_ = y;
  return y + kSuctionHiss * white;
}

float Suction::next(float level) noexcept {
  gurgle_ += slow_gain_ * (slow_.next() - gurgle_);
  const float swell = std::clamp(1.0f + 20.0f * gurgle_, 0.3f, 2.0f);
  return level * swell * gain_ * filtered(noise_.next());
}

Spray::Spray(double sample_rate, std::uint64_t seed)
    : noise_(seed),
      random_(mixed(seed ^ 0xd209)),
      high_pole_(static_cast<float>(1 - std::exp(-2 * kPi * kJetFrom / sample_rate))),
      low_pole_(static_cast<float>(1 - std::exp(-2 * kPi * kJetTo / sample_rate))),
      droplet_probability_(static_cast<float>(kDropletsPerSecond / sample_rate)),
      hiss_gain_(1),
      droplet_gain_(0) {
  // Makes the output's standard deviation 1 for white noise as input: the output is divided by the root of the impulse
  // response's energy.
  float energy = 0;
  for (int i = 0; i < 4096; ++i) {
    const float v = filtered(i == 0 ? 1.0f : 0.0f);
    energy += v * v;
  }
  high_[0] = high_[1] = low_[0] = low_[1] = 0;
  hiss_gain_ = std::sqrt((1 - kDropletPower) / energy);
  droplet_gain_ = std::sqrt(kDropletPower / (energy * droplet_probability_));
}

float Spray::filtered(float x) noexcept {
  for (float& low : high_) {
    low += high_pole_ * (x - low);
    x -= low;
  }
  for (float& low : low_) {
    low += low_pole_ * (x - low);
    x = low;
  }
  return x;
}

float Spray::next(float level) noexcept {
  random_ = mixed(random_);
  const float chance = static_cast<float>(random_ >> 40) * 0x1p-24f;  // random number 0 … 1
  float x = hiss_gain_ * noise_.next();
  if (chance < droplet_probability_) x += (random_ & 1) != 0 ? droplet_gain_ : -droplet_gain_;
  return level * filtered(x);
}

}  // namespace typodont::audio
