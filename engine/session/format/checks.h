// Checks the data of a recording. After these checks, users of a SessionReader can rely on indices, poses, radii, times
// and counts.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/session/session_data.h"

namespace typodont::session {

/// Limits of plausible values, far beyond the values of a real workbench.
struct RecordingLimits {
  // Largest absolute time, ns. Times can be negative, because a stream may begin before the first tick.
  Nanos longest = 30 * 86'400 * kNanosPerSecond;
  // Largest distance of the hand from the origin, m. The servo refuses larger distances.
  double farthest = 100;
  double farthest_cut = 10;  // m, largest distance of a cut from the origin; real cuts are near the tissue
  // Largest length of a cut in one tick, m. A real cut is inside the tissue patch, which is smaller.
  double longest_cut = 0.05;
  double max_fill = 6e-3;                      // m, largest radius of a filled ball; real tools have at most 5 mm
  double max_force = 1e3;                      // N, largest force that a recording may contain
  double fastest_spindle = 1e6;                // rad/s, largest rotation speed of the spindle
  double max_volume = 1;                       // m³, largest volume that a recording may contain
  double lowest_rate = 1, highest_rate = 1e5;  // Hz, smallest and largest rate of the servo
  std::uint64_t max_ticks = 864'000'000;       // largest number of ticks: one day at 10 kHz
  std::uint64_t max_rows_bytes = 4ull << 30;   // bytes, largest table that is kept in memory
};
inline constexpr RecordingLimits kRecordingLimits;

// The check functions throw an Error with file, place (for example "cuts, row 7, index"), found and expected value.

void check_header(const std::string& file, const SessionHeader& header);
/// Checks ticks. `first`: row of the first one. The hand's pose is not checked, because invalid input is recorded
/// unchanged.
void check_ticks(const std::string& file, std::span<const ServoTick> ticks, std::uint64_t first, std::size_t tools);
void check_cuts(const std::string& file, std::span<const Cut> cuts, std::size_t tools);
void check_patches(const std::string& file, std::span<const PatchUse> patches);
void check_times(const std::string& file, const std::string& table, std::span<const Nanos> times);

}  // namespace typodont::session
