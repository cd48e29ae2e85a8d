// Compares a replay with all recorded data that the score depends on: every column of the ticks, every cut, the volumes
// of the tissues at start and end, the final tissue, and the servo's rate. The replay takes the following data from the
// recording, so they are not compared: pose, pedal and times of the hand, the scene with its rules, the ticks at which
// the servo began to use a patch (tissue copy), and the undone strokes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/contract/contact.h"
#include "engine/session/session_file.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Compares the ticks and cuts of a replay with those of the recording. They must be passed in order. Data after the
/// first gap of the recording are not compared. For one thread only.
class StreamCheck {
 public:
  explicit StreamCheck(const session::SessionReader& session);

  /// A difference between the replay and the recording.
  struct Difference {
    std::uint64_t tick;  // index of the tick in which the replay first differs from the recording
    std::string what;    // description of the difference, for example "force at tick 12"
  };
  /// Returns the first difference between the replay and the recording; empty if there is none so far.
  const std::optional<Difference>& difference() const { return difference_; }
  /// Returns true if this tick can be compared. Ticks after the first gap cannot be compared, because the recording
  /// does not contain all input of the servo there.
  bool covers(const ServoTick& recorded) const { return recorded.index <= last_tick_; }

  void volumes_at_start(const PerTissue& volumes);
  void tick(const ServoTick& replayed, const ServoTick& recorded);
  /// Compares a cut that the replay made.
  void cut(const Cut& replayed);
  /// Compares the final tissue. Call it after the last tick.
  void end(const haptics::TissueVolume& tissue);

 private:
  void differs(std::uint64_t tick, std::string what);
  /// Compares the rate with the times of the ticks in contact. Their forces depend on the time since the last tick.
  void rate();
  void volumes(const PerTissue& replayed, const PerTissue& recorded, const char* when);

  const session::SessionReader& session_;
  std::uint64_t last_tick_;  // index of the last tick before the recording's first gap
  std::uint64_t now_ = 0;    // index of the latest tick that was passed to tick()
  std::size_t cut_ = 0;      // index of the next recorded cut
  std::optional<ServoTick> last_;
  // Ticks in contact: their number, those that followed too early or too late, and the sum of their periods in units of
  // the nominal one.
  std::uint64_t contact_ticks_ = 0, early_ = 0, late_ = 0;
  double contact_time_ = 0;
  std::optional<Difference> difference_;
};

}  // namespace typodont
