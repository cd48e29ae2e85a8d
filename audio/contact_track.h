// The contact between tool and tissue over time, from a file of contacts or of servo ticks.
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
  bool has_spindle = false;        // true: the file has a column with the spindle's speed
};

/// Reads a file. Columns: t_s and any of spindle_krpm, pedal, force_N, contact_area_mm2, removal_mm3_per_s, tissue
/// (name or number), slip_mm_per_s, suction (0..1), spray (0..1), cutting (0 or 1). Also reads the ticks of `typodont
/// servo`, and computes force, removal rate and slip from them. Throws Error.
ContactTrack read_contact_track(const std::filesystem::path& file);

/// Returns interpolated states in order, one per millisecond. Without a speed in the file, the spindle is an air
/// turbine loaded by friction: the speed falls linearly from `free_speed` (rad/s) to 0 at the stall torque.
class VoicedTrack {
 public:
  /// `track` must have a row, and outlive this object.
  VoicedTrack(const ContactTrack& track, double free_speed) : track_(track), free_speed_(free_speed) {}

  /// Returns the next state; empty after the last row.
  std::optional<SoundState> next() noexcept;

 private:
  const ContactTrack& track_;
  double free_speed_;
  std::size_t row_ = 0;  // index of the last row of the track that was reached
  Nanos after_ = 0;      // ns, time from the row with the index row_ to the next returned state
};

}  // namespace typodont::audio
