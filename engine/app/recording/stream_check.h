// Compares what a replay makes with everything in a recording that its score is made of: every column of the ticks,
// every cut, the volumes at the start and at the end, the tissue at the end. What it cannot compare are the replay's
// own inputs: the hand's pose and pedal, the scene with its rules, when patches were taken up, strokes taken back.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/contract/contact.h"
#include "engine/session/session_file.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// One thread. Ticks and cuts in their order; what comes behind the recording's first gap is not compared.
class StreamCheck {
 public:
  explicit StreamCheck(const session::SessionReader& session);

  struct Difference {
    std::uint64_t tick;  // index
    std::string what;    // "force at tick 12"
  };
  /// The first one; nothing while there is none.
  const std::optional<Difference>& difference() const { return difference_; }
  /// False from the first gap on: the servo of then did more than the recording tells.
  bool covers(const ServoTick& recorded) const { return recorded.index <= last_tick_; }

  void volumes_at_start(const PerTissue& volumes);
  void tick(const ServoTick& replayed, const ServoTick& recorded);
  /// One that the replay made.
  void cut(const Cut& replayed);
  /// After the last tick.
  void end(const haptics::TissueVolume& tissue);

 private:
  void differs(std::uint64_t tick, std::string what);
  void volumes(const PerTissue& replayed, const PerTissue& recorded, const char* when);

  const session::SessionReader& session_;
  std::uint64_t last_tick_;  // index of the last tick before the first gap
  std::uint64_t now_ = 0;    // index of the newest tick
  std::size_t cut_ = 0;      // the next recorded one
  std::optional<Difference> difference_;
};

}  // namespace typodont
