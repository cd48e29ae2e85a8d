// Synthesizes the drill's sound from the servo's ticks. Deterministic: equal models, rate, seed and states give samples
// with equal bits, for any buffer size.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "audio/sound_models.h"
#include "engine/base/clock.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// The part of a servo tick that determines the sound. Plain data, trivially copyable, SI.
struct SoundState {
  Nanos t = 0;              // ns, time of the tick; the state takes effect at the nearest sample
  double spindle = 0;       // rad/s, spindle speed; negative if it turns backward
  double pedal = 0;         // pedal position, 0..1
  double contact_area = 0;  // m², contact area of the head
  double force = 0;         // N, force of the contact on the tool
  double removal_rate = 0;  // m³/s, volume of tissue that the bur removes per second
  Tissue tissue = Tissue::kAir;
  bool cutting_tool = true;  // false for hand instruments, which only knock and scrape
  double slip_speed = 0;     // m/s, speed along the surface; determines the scraping sound
  double suction = 0;        // strength of the suction's sound, 0..1
  double spray = 0;          // 0..1, flow of the handpiece's water as a fraction of its largest flow
};

struct SynthOptions {
  double hold = 0;  // s; if no SoundState arrives for this time, contact ends and the drill runs down; 0: never
  /// true: each model is reduced to the order with the least Bayesian information criterion (sufficient_order())
  bool lower_order = false;
};

/// Synthesizes the sound of a drill sample by sample. Used by one thread at a time (the audio callback's thread, or the
/// offline renderer's). Only the constructor allocates.
class DrillSynth {
 public:
  DrillSynth(const SoundModels& models, double sample_rate, std::uint64_t seed, const SynthOptions& options = {});
  ~DrillSynth();
  DrillSynth(DrillSynth&&) noexcept;
  DrillSynth& operator=(DrillSynth&&) noexcept;

  /// Adds a state; states come in order of time. If a state is older than the next sample, it takes effect at once and
  /// is counted as late. If more than kPending states wait, the newest is dropped and counted.
  void push(const SoundState& state) noexcept;
  static constexpr std::size_t kPending = 8192;

  /// Renders the next samples; the first call starts at time 0.
  void render(std::span<float> mono) noexcept;
  /// Renders the next samples; the first sample has the time t_first of the ticks' clock (see AudioOutput).
  void render(std::span<float> mono, Nanos t_first) noexcept;

  double sample_rate() const noexcept;
  std::uint64_t late() const noexcept;
  std::uint64_t dropped() const noexcept;
  /// Returns the number of autoregressive filters that the last sample needed: 0 if the drill is silent, 1 if it idles,
  /// 2 if it works.
  int active_filters() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::audio
