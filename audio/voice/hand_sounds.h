// Sounds of knocking, scraping, suction and spray; modelled, not recorded.
#pragma once

#include <array>
#include <cstdint>

#include "audio/ar/noise.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// Modal synthesis: three decaying modes for each tissue (van den Doel & Pai 1998).
class ModalBank {
 public:
  explicit ModalBank(double sample_rate);
  void strike(Tissue tissue, float strength) noexcept;
  float next() noexcept;
  bool silent() const noexcept { return silent_; }

 private:
  static constexpr int kModes = 3;
  struct Mode {
    float re = 0, im = 0;  // current complex amplitude of the mode
    // Complex factor per sample: rotation and decay.
    float turn_re = 0, turn_im = 0;
    float weight = 0;
  };
  std::array<std::array<Mode, kModes>, kTissueCount> modes_;
  std::array<bool, kTissueCount> ringing_{};
  bool silent_ = true;
  int until_check_ = 0;
};

/// Sound of scraping over asperities 20 µm apart: band-pass noise around the number of asperities that the tool passes
/// per second. Soft tissue damps high frequencies.
class Scrape {
 public:
  Scrape(double sample_rate, std::uint64_t seed);
  /// Returns the next sample. `slip`: speed along the surface, m/s.
  float next(float slip, float level, Tissue tissue) noexcept;

 private:
  GaussianNoise noise_;
  float per_radian_;
  float low_ = 0, high_[2] = {}, damped_[2] = {};
  std::array<float, kTissueCount> damping_;  // coefficient of the low-pass filter for each tissue
};

/// Saliva ejector: noise through a resonance, modulated slowly (gurgling).
class Suction {
 public:
  Suction(double sample_rate, std::uint64_t seed);
  /// Returns the next sample. `level`: standard deviation of the sound.
  float next(float level) noexcept;

 private:
  float filtered(float white) noexcept;

  GaussianNoise noise_, slow_;
  float a1_, a2_, gain_, slow_gain_;
  float y1_ = 0, y2_ = 0, gurgle_ = 0;
};

/// Water spray: hiss above 2 kHz, and droplets that burst.
class Spray {
 public:
  Spray(double sample_rate, std::uint64_t seed);
  /// Returns the next sample. `level`: standard deviation of the sound.
  float next(float level) noexcept;

 private:
  float filtered(float x) noexcept;

  GaussianNoise noise_;
  std::uint64_t random_;
  float high_pole_, low_pole_, droplet_probability_, hiss_gain_, droplet_gain_;
  float high_[2] = {}, low_[2] = {};
};

}  // namespace typodont::audio
