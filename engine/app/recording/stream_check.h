// Compares a replay with the recorded ticks, cuts, volumes at start and end, final tissue and servo rate. Input of the
// replay is not compared: hand motion, scene, undone strokes, ticks at which the servo switched to a new copy of the
// tissue.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/contract/contact.h"
#include "engine/session/session_file.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Compares the ticks and cuts of a replay, passed in order, with those of the recording. Data after the first gap of
/// the recording is not compared. For one thread only.
class StreamCheck {
 public:
  explicit StreamCheck(const session::SessionReader& session);

  /// A difference between the replay and the recording.
  struct Difference {
    std::uint64_t tick;  // index of the first tick that differs from the recording
    std::string what;    // description of the difference, for example "force at tick 12"
  };
  /// First difference between replay and recording; empty: none until now.
  const std::optional<Difference>& difference() const { return difference_; }
  /// True if this tick can be compared. After the first gap of the recording, some input of the servo is missing.
  bool covers(const ServoTick& recorded) const { return recorded.index <= last_tick_; }

  void volumes_at_start(const PerTissue& volumes);
  void tick(const ServoTick& replayed, const ServoTick& recorded);
  /// Compares a cut that the replay made.
  void cut(const Cut& replayed);
  /// Compares the replay's final tissue with the recorded hash. Call after the last tick.
  void end(const haptics::TissueVolume& tissue);

 private:
  void differs(std::uint64_t tick, std::string what);
  /// Compares the servo's rate with the periods of the ticks in contact, because forces in contact depend on the time
  /// since the previous tick.
  void rate();
  void volumes(const PerTissue& replayed, const PerTissue& recorded, const char* when);

  const session::SessionReader& session_;
  std::uint64_t last_tick_;  // index of the last tick before the recording's first gap
  std::uint64_t now_ = 0;    // index of the latest tick that was passed to tick()
  std::size_t cut_ = 0;      // index of the next recorded cut
  std::optional<ServoTick> last_;
  // Ticks in contact: their number, those that followed too early or too late, and the sum of their periods in units of
  // the nominal period.
  std::uint64_t contact_ticks_ = 0, early_ = 0, late_ = 0;
  double contact_time_ = 0;
  std::optional<Difference> difference_;
};

}  // namespace typodont
