// The contact of the hand over time, from a file of contacts or of ticks.
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
  bool has_spindle = false;        // the file has a column with the spindle's speed
};

/// Reads a file. Columns: t_s and any of spindle_krpm, pedal, force_N, contact_area_mm2, removal_mm3_per_s, tissue
/// (name or number), slip_mm_per_s, suction (0..1), spray (0..1), cutting (0 or 1). It also reads the ticks of
/// `typodont servo`, from which force, removal rate and slip are computed. Throws Error.
ContactTrack read_contact_track(const std::filesystem::path& file);

/// Returns the states in order, one per millisecond, interpolated. If the file has no spindle speed, it is that of an
/// air turbine: linear from its stall torque to `free_speed` (rad/s), loaded by friction.
class VoicedTrack {
 public:
  /// `track` must have a row, and outlive this object.
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
