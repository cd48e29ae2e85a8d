// Converts the servo's ticks to states of the synthesizer.
#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "audio/drill_synth.h"
#include "engine/contract/contact.h"

namespace typodont::audio {

/// Converts ticks, in order, to states of the sound. Audio thread; never allocates. Removal rate and slip are
/// differences over a fixed time, so they do not depend on the servo's rate.
class TickVoice {
 public:
  /// `tools_cut`: for each tool, true for a bur; other tools only knock and scrape.
  explicit TickVoice(std::vector<bool> tools_cut) : tools_cut_(std::move(tools_cut)) {}

  SoundState state_of(const ServoTick& tick) noexcept;
  static constexpr Nanos kDifferenceOver = 5'000'000;

 private:
  struct Seen {
    Nanos t = 0;
    double removed = 0;  // m³, volume removed so far, sum over all tissues
    dvec3 p_WG{0, 0, 0};
  };
  static constexpr std::size_t kSeen = 64;  // number of stored ticks, enough for a servo of 12 kHz
  std::array<Seen, kSeen> seen_{};
  // Number of ticks so far, and index of the earlier tick from which differences are computed.
  std::size_t count_ = 0, back_ = 0;
  std::vector<bool> tools_cut_;
};

}  // namespace typodont::audio
