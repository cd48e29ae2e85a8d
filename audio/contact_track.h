// A table of the hand's contact over time. It comes from a contact file for `typodont sound synth`, or from the ticks
// of a servo run.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "audio/drill_synth.h"

namespace typodont::audio {

struct ContactTrack {
  std::vector<SoundState> states;  // the states of the sound, in order of time
  double fastest = 0;              // rad/s, highest spindle speed of the track
  double end = 0;                  // s, time of the last row
  bool has_spindle = false;        // true if the file has a column with the spindle speed
};

/// Reads a contact file. It has the column t_s and any of spindle_krpm, pedal, force_N, contact_area_mm2,
/// removal_mm3_per_s, tissue (a name or its number), slip_mm_per_s, suction (0..1), spray (0..1), cutting (0 or 1).
/// Also reads ticks written by `typodont servo`, and computes force, removal rate and slip from them. Throws Error with
/// the file, the line, the column, the value that was found, and the value that was expected.
ContactTrack read_contact_track(const std::filesystem::path& file);

/// Returns the states of a track in order. Between two rows, it interpolates one state per millisecond; the tissue is
/// that of the earlier row. If the track has no spindle speed, the speed is computed as for an air turbine, whose
/// torque falls linearly from stall to free speed. Without contact, the speed is `free_speed` (rad/s) while the pedal
/// is pressed. In contact, the friction at the bur reduces the speed.
class VoicedTrack {
 public:
  /// The track must outlive this object and have at least one row.
  VoicedTrack(const ContactTrack& track, double free_speed) : track_(track), free_speed_(free_speed) {}

  /// Returns the next state; empty after the last row.
  std::optional<SoundState> next() noexcept;

 private:
  const ContactTrack& track_;
  double free_speed_;
  std::size_t row_ = 0;  // index of the last table row whose time has passed
  Nanos after_ = 0;      // ns, time since the row with the index row_
};

}  // namespace typodont::audio
