// After these checks, users of a SessionReader can rely on indices, poses, radii, times and counts.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/session/session_data.h"

namespace typodont::session {

/// Plausible values, far beyond a real bench.
struct RecordingLimits {
  // ns, either sign: a stream may begin before the first tick.
  Nanos longest = 30 * 86'400 * kNanosPerSecond;
  // m, of the hand; the servo refuses more
  double farthest = 100;
  double farthest_cut = 10;  // m, of a cut; real ones are near the tissue
  // m, of one tick's cut; real ones lie in the patch, which is smaller
  double longest_cut = 0.05;
  double largest_fill = 6e-3;                  // m; real tools have at most 5 mm
  double greatest_force = 1e3;                 // N, largest force that a recording may contain
  double fastest_spindle = 1e6;                // rad/s, largest rotation speed of the spindle
  double largest_volume = 1;                   // m³, largest volume that a recording may contain
  double lowest_rate = 1, highest_rate = 1e5;  // Hz, smallest and largest rate of the servo
  std::uint64_t most_ticks = 864'000'000;      // a day at 10 kHz
  std::uint64_t most_rows_bytes = 4ull << 30;  // bytes of a table kept in memory
};
inline constexpr RecordingLimits kRecordingLimits;

// Error with file, place ("cuts, row 7, index"), found and expected value.

void check_header(const std::string& file, const SessionHeader& header);
/// `first`: row of the first tick. The hand's pose is not checked: invalid input is recorded unchanged.
void check_ticks(const std::string& file, std::span<const ServoTick> ticks, std::uint64_t first, std::size_t tools);
void check_cuts(const std::string& file, std::span<const Cut> cuts, std::size_t tools);
void check_patches(const std::string& file, std::span<const PatchUse> patches);
void check_times(const std::string& file, const std::string& table, std::span<const Nanos> times);

}  // namespace typodont::session
