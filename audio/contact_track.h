// A table of the hand's contact over time: contact files for `typodont sound synth`, or the ticks of a servo run.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "audio/drill_synth.h"

namespace typodont::audio {

struct ContactTrack {
  std::vector<SoundState> states;  // in order of time
  double fastest = 0;              // rad/s, highest spindle speed of the track
  double end = 0;                  // s, time of the last row
  bool has_spindle = false;        // a column gives the spindle speed
};

/// Reads a contact file: t_s and any of spindle_krpm, pedal, force_N, contact_area_mm2, removal_mm3_per_s, tissue (a
/// name or its number), slip_mm_per_s, suction (0..1), spray (0..1), cutting (0 or 1). Also reads ticks written by
/// `typodont servo`, from which force, removal rate and slip are computed. Throws Error naming file, line, column,
/// found and expected.
ContactTrack read_contact_track(const std::filesystem::path& file);

/// Returns the states of a track in order. Between two rows, it interpolates a state every millisecond; the tissue of
/// the earlier row applies. If the track has no spindle speed, the speed is `free_speed` (rad/s) while the pedal is
/// pressed, reduced by the bur's friction as for an air turbine, whose torque falls linearly from stall to free
/// speed.
class VoicedTrack {
 public:
  /// The track must outlive this object and have at least one row.
  VoicedTrack(const ContactTrack& track, double free_speed) : track_(track), free_speed_(free_speed) {}

  /// The next state; empty after the last row.
  std::optional<SoundState> next() noexcept;

 private:
  const ContactTrack& track_;
  double free_speed_;
  std::size_t row_ = 0;  // the last row that was passed
  Nanos after_ = 0;      // ns, time since this row
};

}  // namespace typodont::audio
