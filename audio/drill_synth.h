// Synthesizes the sound of the drill from the servo's ticks. Equal models, rate, seed and states give bit-identical
// sound, for any buffer size.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "audio/sound_models.h"
#include "engine/base/clock.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// The data of a servo tick that affects the sound, in SI units.
struct SoundState {
  Nanos t = 0;              // ns; the state takes effect at the nearest sample
  double spindle = 0;       // rad/s, spindle speed; negative if it turns backward
  double pedal = 0;         // pedal position, 0..1
  double contact_area = 0;  // m², contact area of the head
  double force = 0;         // N, force of the contact on the tool
  double removal_rate = 0;  // m³/s, volume of tissue that the bur removes per second
  Tissue tissue = Tissue::kAir;
  bool cutting_tool = true;  // false for hand instruments, which only knock and scrape
  double slip_speed = 0;     // m/s, speed of the tool along the tissue surface; determines the scraping sound
  double suction = 0;        // strength of the suction's sound, 0..1
  double spray = 0;          // flow of the spray as a fraction of its maximum
};

struct SynthOptions {
  double hold = 0;  // s; if no new state arrives for this time, contact ends and the drill runs down; 0: no limit
  /// Uses models of lower order (sufficient_order()).
  bool lower_order = false;
};

/// Used by one thread. Only the constructor allocates.
class DrillSynth {
 public:
  DrillSynth(const SoundModels& models, double sample_rate, std::uint64_t seed, const SynthOptions& options = {});
  ~DrillSynth();
  DrillSynth(DrillSynth&&) noexcept;
  DrillSynth& operator=(DrillSynth&&) noexcept;

  /// Adds a state; states must be in order of time. A late state acts at once and is counted. If kPending states wait
  /// already, the new one is dropped and counted.
  void push(const SoundState& state) noexcept;
  static constexpr std::size_t kPending = 8192;

  /// Renders the next samples; the first one has time 0.
  void render(std::span<float> mono) noexcept;
  /// Renders samples from the time `t_first` on the clock of the ticks (see AudioOutput).
  void render(std::span<float> mono, Nanos t_first) noexcept;

  double sample_rate() const noexcept;
  std::uint64_t late() const noexcept;
  std::uint64_t dropped() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::audio
