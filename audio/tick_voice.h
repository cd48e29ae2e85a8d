// Converts the servo's ticks to states of the synthesizer.
#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "audio/drill_synth.h"
#include "engine/contract/contact.h"

namespace typodont::audio {

/// Ticks in order to sound states, on the audio thread. Never allocates. Removal rate and slip are differences over a
/// fixed time, at any servo rate.
class TickVoice {
 public:
  /// per tool: a bur; others only knock and scrape
  explicit TickVoice(std::vector<bool> tools_cut) : tools_cut_(std::move(tools_cut)) {}

  SoundState state_of(const ServoTick& tick) noexcept;
  static constexpr Nanos kDifferenceOver = 5'000'000;

 private:
  struct Seen {
    Nanos t = 0;
    double removed = 0;  // m³, volume removed so far, sum over all tissues
    dvec3 p_WG{0, 0, 0};
  };
  static constexpr std::size_t kSeen = 64;  // ticks kept, enough for 12 kHz
  std::array<Seen, kSeen> seen_{};
  // ticks so far; the earlier tick of the differences
  std::size_t count_ = 0, back_ = 0;
  std::vector<bool> tools_cut_;
};

}  // namespace typodont::audio
