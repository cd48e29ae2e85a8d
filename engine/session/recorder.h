// Writes a session to disk while it runs. The program's recorder thread owns the writer, passes the contents of the
// rings to append() and calls heartbeat() often. If the process is killed, the file can be opened and contains all
// data up to half a second before. The file is HDF5 in single-writer-multiple-readers mode: after every flush it is
// readable, so another process can also watch a running session. docs/session_format.md describes the layout.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "engine/contract/contact.h"
#include "engine/contract/loop_timing.h"
#include "engine/session/session_data.h"

namespace typodont::session {

struct WriterOptions {
  Nanos flush_interval = kNanosPerSecond / 2;  // ns, longest time that data is stored only in memory (heartbeat)
  int deflate = 3;                             // compression level 1..9; the bytes are shuffled first to save space
  // Free bytes on the disk, three limits. With less than `disk_needed`, the constructor throws Error. Below
  // `disk_low`, the status contains a warning. Below `disk_reserve` (about two flushes with their journal), rows are
  // counted as lost instead of written.
  std::uint64_t disk_needed = 16u << 20, disk_low = 64u << 20, disk_reserve = 4u << 20;
  std::function<std::uint64_t()> free_bytes;  // returns the free bytes on the disk; empty: the file system is asked
  // true: writes a temporary file and renames it in finish(); for results, not for live sessions
  bool whole_or_nothing = false;
  // true: writes a recorded session again, so all events are given and none is derived from ticks
  bool rewrites = false;
  Lost lost_before;  // losses of the original recording, if a recorded session is written to a new file
};

/// State of the recording. `message` describes a refused operation, or a nearly full disk.
struct WriterStatus {
  enum class State { kRecording, kDiskLow, kDiskFull, kFailed, kFinished } state = State::kRecording;
  Lost lost;
  std::uint64_t ticks = 0, cuts = 0;  // numbers of rows written to the file
  Nanos slowest_flush = 0;            // ns of wall time, duration of the slowest write so far
  std::string message;
};

/// Writes one session file. One thread at a time. The constructor throws Error if the file cannot be created. The
/// other functions never throw: losses on a full or failing disk are counted in status(), and the session continues.
class SessionWriter {
 public:
  SessionWriter(const std::filesystem::path& file, const SessionHeader& header, const WriterOptions& options = {});
  ~SessionWriter();  // writes all buffered data, and then stops the recording as a kill would
  SessionWriter(const SessionWriter&) = delete;
  SessionWriter& operator=(const SessionWriter&) = delete;

  // Append patches and cuts before the ticks that name them. Then the file is complete up to its last tick.
  void append(std::span<const ServoTick> ticks) noexcept;
  void append(std::span<const Cut> cuts) noexcept;
  void append(std::span<const PatchUse> patches) noexcept;
  void append(const SessionEvent& event) noexcept;
  void event(Nanos t, EventKind kind, std::string_view text) noexcept;
  /// Sets the timing of the servo loop up to now. The next flush writes the newest timing.
  void loop(const LoopReport& report) noexcept;
  /// Adds one sample to header.streams[stream], with one value for each of the stream's columns.
  void append(std::size_t stream, Nanos t, std::span<const double> values) noexcept;

  /// Sets the total numbers of values that the rings have dropped (Ring::dropped()). The file stores these numbers.
  void count_ring_losses(std::uint64_t ticks, std::uint64_t cuts, std::uint64_t other) noexcept;

  /// Call at least every 100 ms. Writes data that is older than the flush interval.
  void heartbeat() noexcept;
  /// Writes all data so far. When the function returns, the operating system has this data.
  void flush() noexcept;
  /// Writes the remaining data and the result, and closes the file. Returns false if data is missing (see status()).
  bool finish(const SessionResult& result) noexcept;

  const WriterStatus& status() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::session
