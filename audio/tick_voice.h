// Converts the servo's ticks to states of the synthesizer.
#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "audio/drill_synth.h"
#include "engine/contract/contact.h"

namespace typodont::audio {

/// Computes the sound's state from every tick in order, on one thread (the audio callback's). Never allocates. Removal
/// rate and slip are differences over several ticks, because differences of single ticks are noisy. These ticks span a
/// fixed time at every servo rate, so the sound does not depend on the servo rate.
class TickVoice {
 public:
  /// `tools_cut`: for each tool of the session, true if the tool is a bur. Other tools only knock and scrape.
  explicit TickVoice(std::vector<bool> tools_cut) : tools_cut_(std::move(tools_cut)) {}

  SoundState state_of(const ServoTick& tick) noexcept;
  static constexpr Nanos kDifferenceOver = 5'000'000;

 private:
  struct Seen {
    Nanos t = 0;
    double removed = 0;  // m³, volume removed so far, sum over all tissues
    dvec3 p_WG{0, 0, 0};
  };
  static constexpr std::size_t kSeen = 64;  // number of ticks in the ring buffer, sufficient for a servo rate of 12 kHz
  std::array<Seen, kSeen> seen_{};
  // count_: number of ticks so far; back_: index of the earlier tick from which the differences to the latest tick are
  // computed
  std::size_t count_ = 0, back_ = 0;
  std::vector<bool> tools_cut_;
};

}  // namespace typodont::audio
