// What the hand did, as a table: contact files for `typodont sound synth`, or a servo run's ticks.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "audio/drill_synth.h"

namespace typodont::audio {

struct ContactTrack {
  std::vector<SoundState> states;  // in order of time
  double fastest = 0;              // rad/s, the highest spindle speed in it
  double end = 0;                  // s, time of the last row
  bool has_spindle = false;        // a column said how fast the spindle turned
};

/// A contact file: t_s and any of spindle_krpm, pedal, force_N, contact_area_mm2, removal_mm3_per_s, tissue (a name or
/// its number), slip_mm_per_s, suction (0..1), cutting (0 or 1). Or ticks as `typodont servo` writes them, from which
/// force, removal rate and slip follow.
/// Throws Error naming file, line, column, found and expected.
ContactTrack read_contact_track(const std::filesystem::path& file);

/// Voices a track, state by state as it is heard: those between its rows are interpolated every millisecond, a tissue
/// holds until the next row. Where the track does not tell the spindle's speed, it is `free_speed` (rad/s) while the
/// pedal is down, less what the bur's friction costs an air turbine: its torque falls straight from stall to free
/// speed.
class VoicedTrack {
 public:
  /// The track outlives it, and has a row.
  VoicedTrack(const ContactTrack& track, double free_speed) : track_(track), free_speed_(free_speed) {}

  /// The next state; nothing after the track's last row.
  std::optional<SoundState> next() noexcept;

 private:
  const ContactTrack& track_;
  double free_speed_;
  std::size_t row_ = 0;  // the last one passed …
  Nanos after_ = 0;      // … and how long ago
};

}  // namespace typodont::audio
