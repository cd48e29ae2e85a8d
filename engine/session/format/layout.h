// Definitions for the writer and the reader of session files. The columns are defined in columns.h.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "engine/contract/loop_timing.h"
#include "engine/session/format/columns.h"
#include "engine/session/session_data.h"

namespace typodont::session {

inline constexpr const char* kFormatName = "typodont-session";
inline constexpr std::uint64_t kFormatVersion = 1;
// Largest length, in bytes, of the text in one row of the events. A longer text continues in the next rows.
inline constexpr std::size_t kEventText = 256;
inline constexpr std::size_t kPictureText = 128;  // bytes, largest length of a picture's name or title

inline constexpr const char* kLostLabels =
    "0 ticks_ring, 1 cuts_ring, 2 ticks_disk, 3 cuts_disk, 4 other_disk, 5 other_ring, 6 pictures_disk";
// Number of lost-data counters in files of the first version.
inline constexpr std::size_t kLostAtFirst = 5;
inline std::array<std::uint64_t, 7> as_array(const Lost& lost) {
  return {lost.ticks_ring, lost.cuts_ring,  lost.ticks_disk,   lost.cuts_disk,
          lost.other_disk, lost.other_ring, lost.pictures_disk};
}

/// The numbers and names of the kinds of events: "0 note, 1 tool, …".
std::string event_labels();

/// Names of the values in the group "loop", which stores a LoopReport as numbers.
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

  /// Calls f(name, type, text, labels, numbers) for each dataset of the group, in the file's order, until one call
  /// returns false. Returns false then.
  template <class F>
  bool each(F&& f) {
    return f("times", Type::kU64, "of the servo's loop; no ticks: a session that did not run live", kLoopTimeLabels,
             times) &&
           f("jitter", Type::kU32, kHistogramText, "", jitter) && f("work", Type::kU32, kHistogramText, "", work) &&
           f("granted", Type::kU64, "1: granted by the operating system", kLoopGrantLabels, granted) &&
           f("note", Type::kU8, "UTF-8: what was refused and what mends it", "", note) &&
           f("hand", Type::kF64, "of a hand with motors", kLoopHandLabels, hand) &&
           f("safety", Type::kU64, "what the safety layer did, as bits", safety_labels(), safety);
  }
};

// While the file is recorded, locks a byte far beyond its end. The lock ends with the process, so a reader can tell a
// running recording from a killed one. Returns a descriptor that the caller must close, or -1. HDF5's own lock does
// not suffice, because HDF5 releases it when it starts SWMR (single writer, multiple readers).
int lock_while_recording(const std::filesystem::path& file);
bool is_being_recorded(int fd);
bool is_being_recorded(const std::filesystem::path& file);

}  // namespace typodont::session
