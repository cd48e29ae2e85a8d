// From the servo's ticks to what the synthesizer needs of them.
#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "audio/drill_synth.h"
#include "engine/contract/contact.h"

namespace typodont::audio {

/// Feed it every tick in order, on one thread (the audio callback's); never allocates. Removal rate and slip are
/// differences over some ticks, because single ones are noisy; over as long at any rate, so that it sounds alike.
class TickVoice {
 public:
  /// Of every tool of the session, in their order, whether it cuts; hand instruments scrape and tap.
  explicit TickVoice(std::vector<bool> tools_cut) : tools_cut_(std::move(tools_cut)) {}

  SoundState state_of(const ServoTick& tick) noexcept;
  static constexpr Nanos kDifferenceOver = 5'000'000;

 private:
  struct Seen {
    Nanos t = 0;
    double removed = 0;  // m³, all tissues
    dvec3 p_WG{0, 0, 0};
  };
  static constexpr std::size_t kSeen = 64;  // a ring: enough for 12 kHz
  std::array<Seen, kSeen> seen_{};
  std::size_t count_ = 0, back_ = 0;  // seen so far; the one that differences are taken to
  std::vector<bool> tools_cut_;
};

}  // namespace typodont::audio
