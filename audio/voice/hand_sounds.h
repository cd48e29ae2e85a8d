// Sounds of taps, scraping and suction, which are audible when no drill runs. Modelled, not recorded.
#pragma once

#include <array>
#include <cstdint>

#include "audio/ar/noise.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// Three decaying modes per tissue (van den Doel & Pai 1998), excited by taps and by scraping.
class ModalBank {
 public:
  explicit ModalBank(double sample_rate);
  void strike(Tissue tissue, float strength) noexcept;
  float next() noexcept;
  bool silent() const noexcept { return silent_; }

 private:
  static constexpr int kModes = 3;
  struct Mode {
    float re = 0, im = 0;            // complex amplitude of the mode
    float turn_re = 0, turn_im = 0;  // factor per sample: rotation and decay
    float weight = 0;
  };
  std::array<std::array<Mode, kModes>, kTissueCount> modes_;
  std::array<bool, kTissueCount> ringing_{};
  bool silent_ = true;
  int until_check_ = 0;
};

/// A tip that slides over asperities 20 µm apart: band-pass noise around the rate at which it meets them.
class Scrape {
 public:
  Scrape(double sample_rate, std::uint64_t seed);
  /// `slip`: m/s. `level`: the wanted amplitude.
  float next(float slip, float level) noexcept;

 private:
  GaussianNoise noise_;
  float per_radian_;
  float low_ = 0, high_ = 0;
};

/// A saliva ejector: noise through a resonance, modulated slowly (gurgling).
class Suction {
 public:
  Suction(double sample_rate, std::uint64_t seed);
  float next(float level) noexcept;

 private:
  GaussianNoise noise_, slow_;
  float a1_, a2_, gain_, slow_gain_;
  float y1_ = 0, y2_ = 0, gurgle_ = 0;
};

}  // namespace typodont::audio
