// Checks the values in a session file when the file is read. After that, users of a SessionReader need not check
// indices, poses, radii, times or counts again.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/session/session_data.h"

namespace typodont::session {

/// Plausibility limits for a recording. They are far beyond the values of a real bench.
struct RecordingLimits {
  // ns, limit of |time|; times may be negative, because streams may begin before the first tick
  Nanos longest = 30 * 86'400 * kNanosPerSecond;
  double farthest = 100;     // m, limit of the distance from the workbench's origin; the servo refuses a hand beyond it
  double farthest_cut = 10;  // m, limit of a cut's distance from the origin; real cuts are near the tissue
  double longest_cut = 0.05;                   // m, length of one tick's cut; a surface patch is smaller than this
  double largest_fill = 6e-3;                  // m, limit of the radius; real tools have at most 5 mm
  double greatest_force = 1e3;                 // N, limit of the force
  double fastest_spindle = 1e6;                // rad/s, limit of the spindle's speed
  double largest_volume = 1;                   // m³, limit of a volume
  double lowest_rate = 1, highest_rate = 1e5;  // Hz, limits of the servo's rate
  std::uint64_t most_ticks = 864'000'000;      // limit: number of ticks in a day at 10 kHz
  std::uint64_t most_rows_bytes = 4ull << 30;  // bytes, limit of a table that is kept completely in memory
};
inline constexpr RecordingLimits kRecordingLimits;

// All functions below throw Error(`file`, "cuts, row 7, index", found, expected).

void check_header(const std::string& file, const SessionHeader& header);
/// `first`: row of the first tick in the file. Indices increase from tick to tick. A hand's pose may have any value,
/// because the servo records invalid input unchanged.
void check_ticks(const std::string& file, std::span<const ServoTick> ticks, std::uint64_t first, std::size_t tools);
void check_cuts(const std::string& file, std::span<const Cut> cuts, std::size_t tools);
void check_patches(const std::string& file, std::span<const PatchUse> patches);
void check_times(const std::string& file, const std::string& table, std::span<const Nanos> times);

}  // namespace typodont::session
