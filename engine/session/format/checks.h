// Checks the values in a session file when it is read. After these checks, code that uses a SessionReader can rely on
// valid indices, poses, radii, times and counts.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/session/session_data.h"

namespace typodont::session {

/// Limits for plausible values of a recording. They are far beyond the values of a real bench.
struct RecordingLimits {
  // ns, largest absolute value of a time. Times may be negative, because a recorded stream may begin before the first
  // tick.
  Nanos longest = 30 * 86'400 * kNanosPerSecond;
  // m, largest distance of the hand from the workbench's origin; the servo refuses a hand farther away
  double farthest = 100;
  double farthest_cut = 10;  // m, largest distance of a cut from the origin; real cuts are near the tissue
  // m, largest distance between the first and the last pose of one tick's cut. A real cut is shorter, because it lies
  // in the patch (the copy of the tissue around the tool), and the patch is smaller than this.
  double longest_cut = 0.05;
  double largest_fill = 6e-3;                  // m, largest radius of a filled ball; real tools have at most 5 mm
  double greatest_force = 1e3;                 // N, largest force that a recording may contain
  double fastest_spindle = 1e6;                // rad/s, largest rotation speed of the spindle
  double largest_volume = 1;                   // m³, largest volume that a recording may contain
  double lowest_rate = 1, highest_rate = 1e5;  // Hz, smallest and largest rate of the servo
  std::uint64_t most_ticks = 864'000'000;      // largest number of ticks: a day at 10 kHz
  std::uint64_t most_rows_bytes = 4ull << 30;  // bytes, largest size of a table that is stored completely in memory
};
inline constexpr RecordingLimits kRecordingLimits;

// Each function below throws an Error that names the file, the position (for example "cuts, row 7, index"), the value
// found and the value expected.

void check_header(const std::string& file, const SessionHeader& header);
/// Checks that the ticks' indices increase from tick to tick. `first` is the row of the first tick in the file. The
/// hand's pose is not checked, because the servo records invalid input unchanged.
void check_ticks(const std::string& file, std::span<const ServoTick> ticks, std::uint64_t first, std::size_t tools);
void check_cuts(const std::string& file, std::span<const Cut> cuts, std::size_t tools);
void check_patches(const std::string& file, std::span<const PatchUse> patches);
void check_times(const std::string& file, const std::string& table, std::span<const Nanos> times);

}  // namespace typodont::session
