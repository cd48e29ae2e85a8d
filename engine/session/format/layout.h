// Definitions that the writer and the reader of session files both use, besides the columns.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "engine/contract/loop_timing.h"
#include "engine/session/session_data.h"

namespace typodont::session {

inline constexpr const char* kFormatName = "typodont-session";
inline constexpr std::uint64_t kFormatVersion = 1;
// bytes, length of an event's text; a longer text continues in the next rows
inline constexpr std::size_t kEventText = 256;
inline constexpr std::size_t kPictureText = 128;  // bytes, length of a picture's name and title

inline constexpr const char* kLostLabels =
    "0 ticks_ring, 1 cuts_ring, 2 ticks_disk, 3 cuts_disk, 4 other_disk, 5 other_ring, 6 pictures_disk";
inline constexpr std::size_t kLostAtFirst = 5;  // number of loss counters in files of older versions
inline std::array<std::uint64_t, 7> as_array(const Lost& lost) {
  return {lost.ticks_ring, lost.cuts_ring,  lost.ticks_disk,   lost.cuts_disk,
          lost.other_disk, lost.other_ring, lost.pictures_disk};
}

/// Numbers and names of the event kinds: "0 note, 1 tool, …".
std::string event_labels();

/// The group "loop": a LoopReport as numbers.
inline constexpr const char* kLoopTimeLabels =
    "0 period_ns, 1 ticks, 2 misses, 3 worst_tick_index, 4 worst_tick_ns, 5 worst_jitter_ns";
inline constexpr const char* kLoopGrantLabels = "0 fifo, 1 pinned_core, 2 locked_memory";
inline constexpr const char* kLoopHandLabels = "0 heat, 1 worst_heat, 2 bearable_force_N, 3 armed";
inline constexpr const char* kHistogramText =
    "durations in bins of equal ratio: bin 0 up to 100 ns, bin i up to 100 ns * 2^(i/8), the last without end";
std::string safety_labels();
struct LoopFields {
  std::array<std::uint64_t, 6> times{};
  std::array<std::uint32_t, DurationHistogram::kBins> jitter{}, work{};
  std::array<std::uint64_t, 3> granted{};
  std::array<std::uint8_t, 320> note{};
  std::array<double, 4> hand{};
  std::array<std::uint64_t, 1> safety{};

  LoopFields() = default;
  explicit LoopFields(const LoopReport& report);
  LoopReport report() const;
};

// HDF5 releases its own lock when SWMR starts. Therefore the writer holds another lock, on a byte far behind the end of
// the file. With this lock a reader distinguishes a running session from a killed one. The lock ends with the process.
int lock_while_recording(const std::filesystem::path& file);  // returns a descriptor to close, or -1
bool is_being_recorded(const std::filesystem::path& file);

}  // namespace typodont::session
