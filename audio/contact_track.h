// What the hand did, as a table: contact files for `typodont sound synth`, or a servo run's ticks.
#pragma once

#include <filesystem>
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

/// Voices a track: the states between its rows are interpolated every millisecond, a tissue holds until the next row.
/// Where the track does not tell the spindle's speed, it is `free_speed` while the pedal is down, less what the bur's
/// friction costs an air turbine: its torque falls straight from stall to free speed.
std::vector<SoundState> voiced_states(const ContactTrack& track, double free_speed);

}  // namespace typodont::audio
