#include "audio/binaural.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/base/units.h"

namespace typodont::audio {

namespace {

constexpr double kOmega = kSpeedOfSound / kHeadRadius;  // rad/s, ω0 in the filter of the acoustic shadow
constexpr double kMinShadow = 0.1;                      // α_min, smallest factor of the acoustic shadow
constexpr double kDarkest = 150.0 / 180 * kPi;          // rad, θ_min: angle with the deepest acoustic shadow
constexpr int kReach = 2;                               // samples on each side that the interpolation reads

}  // namespace

EarAngles ear_angles(const dvec3& source_W, const dvec3& eyes_W, const dvec3& right_W) {
  dvec3 ahead = source_W - eyes_W;
  ahead -= right_W * glm::dot(ahead, right_W);
  const double length = glm::length(ahead);
  if (!(length > 1e-9)) return {};
  const dvec3 centre = eyes_W - ahead * (kEarsBehindEyes / length);
  const dvec3 away = source_W - centre;
  const double distance = glm::length(away);
  if (!(distance > kHeadRadius)) return {};
  const double right = std::acos(std::clamp(glm::dot(away, right_W) / distance, -1.0, 1.0));
  return {kPi - right, right};
}

double ear_delay(double angle) {
  const double unit = kHeadRadius / kSpeedOfSound;
  return angle < kPi / 2 ? -unit * std::cos(angle) : unit * (angle - kPi / 2);
}

double ear_shadow(double angle) {
  return 1 + kMinShadow / 2 + (1 - kMinShadow / 2) * std::cos(angle / kDarkest * kPi);
}

Binaural::Binaural(double sample_rate) : rate_(sample_rate), glide_(1 - std::exp(-1 / (kGlide * sample_rate))) {
  // Coefficients from the bilinear transform of (1 + jαω/2ω0) / (1 + jω/2ω0); k = rate / ω0.
  const double k = rate_ / kOmega;
  input_ = 1 / (1 + k);
  slope_ = k / (1 + k);
  pole_ = (1 - k) / (1 + k);
  const double longest = (ear_delay(kPi) - ear_delay(0)) * rate_ + 2 * kReach + 2;
  line_.assign(std::bit_ceil(static_cast<std::size_t>(longest) + 1), 0.0f);
  turn({});
  turned_ = false;
}

void Binaural::turn(const EarAngles& angles) noexcept {
  const double given[2] = {angles.left, angles.right};
  for (int e = 0; e < 2; ++e) {
    const double angle = std::isfinite(given[e]) ? std::clamp(given[e], 0.0, kPi) : kPi / 2;
    ears_[e].wanted_delay = (ear_delay(angle) - ear_delay(0)) * rate_ + kReach;
    ears_[e].wanted_shadow = ear_shadow(angle);
    if (turned_) continue;
    ears_[e].delay = ears_[e].wanted_delay;
    ears_[e].shadow = ears_[e].wanted_shadow;
  }
  turned_ = true;
}

double Binaural::latency() const noexcept {
  return -ear_delay(0) + kReach / rate_;
}

/// Returns the sound `delay` samples ago (cubic Catmull–Rom interpolation).
float Binaural::read(double delay) const noexcept {
  const auto whole = static_cast<std::size_t>(delay);
  const auto t = static_cast<float>(delay - static_cast<double>(whole));
  const std::size_t mask = line_.size() - 1;
  const auto past = [&](std::size_t ago) { return line_[(at_ - ago) & mask]; };
  const float a = past(whole - 1), b = past(whole), c = past(whole + 1), d = past(whole + 2);
  return b + 0.5f * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

void Binaural::render(std::span<const float> mono, std::span<float> stereo) noexcept {
  const auto input = static_cast<float>(input_), slope = static_cast<float>(slope_), pole = static_cast<float>(pole_);
  for (std::size_t i = 0; i < mono.size(); ++i) {
    at_ = (at_ + 1) & (line_.size() - 1);
    line_[at_] = mono[i];
    for (std::size_t e = 0; e < 2; ++e) {
      Ear& ear = ears_[e];
      ear.delay += glide_ * (ear.wanted_delay - ear.delay);
      ear.shadow += glide_ * (ear.wanted_shadow - ear.shadow);
      const float x = read(ear.delay);
      const float y =
          input * (x + ear.before) + static_cast<float>(ear.shadow) * slope * (x - ear.before) - pole * ear.after;
      ear.before = x;
      ear.after = std::abs(y) < 1e-20f ? 0.0f : y;  // replaces denormal numbers by zero
      stereo[2 * i + e] = y;
    }
  }
}

}  // namespace typodont::audio
