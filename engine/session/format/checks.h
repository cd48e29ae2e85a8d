// The one place where what a session file claims is checked on reading. Whoever holds a SessionReader need not ask
// again whether an index, a pose, a radius, a time or a count is possible.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/session/session_data.h"

namespace typodont::session {

/// What a recording may claim. Generous: a real bench stays far inside.
struct RecordingLimits {
  Nanos longest = 30 * 86'400 * kNanosPerSecond;  // ns, either way: streams may begin before the first tick
  double farthest = 100;                          // m, from the workbench's origin; the servo takes no hand beyond
  double farthest_cut = 10;                       // m, the same of cuts, which are where tissue is
  double longest_cut = 0.05;                      // m, of one tick's cut; a surface patch is smaller
  double largest_fill = 6e-3;                     // m, radius; tools reach 5 mm at most
  double greatest_force = 1e3;                    // N
  double fastest_spindle = 1e6;                   // rad/s
  double largest_volume = 1;                      // m³
  double lowest_rate = 1, highest_rate = 1e5;     // Hz
  std::uint64_t most_ticks = 864'000'000;         // a day at 10 kHz
  std::uint64_t most_rows_bytes = 4ull << 30;     // of a table that is kept in memory as a whole
};
inline constexpr RecordingLimits kRecordingLimits;

// All throw Error(`file`, "cuts, row 7, index", found, expected).

void check_header(const std::string& file, const SessionHeader& header);
/// `first`: the row of the first one in the file. Indices increase from one tick to the next; a hand's pose may be
/// anything, since the servo records bad input as it came.
void check_ticks(const std::string& file, std::span<const ServoTick> ticks, std::uint64_t first, std::size_t tools);
void check_cuts(const std::string& file, std::span<const Cut> cuts, std::size_t tools);
void check_patches(const std::string& file, std::span<const PatchUse> patches);
void check_times(const std::string& file, const std::string& table, std::span<const Nanos> times);

}  // namespace typodont::session
