// Writes a session to disk while it runs. The program's recorder thread owns the writer. It passes the content of its
// queues to append() and calls heartbeat() often. If the process is killed, the file can still be opened, and only the
// last half second is missing. The file is in HDF5's mode SWMR (single writer, multiple readers): it is readable after
// every flush, so another process can read a session that is being recorded. docs/session_format.md describes the
// file's layout.
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
  // ns, longest time for which data is only in memory, if heartbeat() is called
  Nanos flush_interval = kNanosPerSecond / 2;
  int deflate = 3;  // level of the compression of the recording's data (deflate), 1..9
  // Limits of the free space on the disk, in bytes. If it is less than `disk_needed`, the constructor throws Error.
  // Below `disk_low`, the status contains a warning. Below `disk_reserve` (about two flushes with their journal), rows
  // are not written and are counted as lost.
  std::uint64_t disk_needed = 16u << 20, disk_low = 64u << 20, disk_reserve = 4u << 20;
  std::function<std::uint64_t()> free_bytes;  // returns the free space in bytes; if empty, the file system is asked
  // True: the writer writes a temporary file, and finish() renames it. Use this for results and not for live sessions.
  bool whole_or_nothing = false;
  // True: the writer copies a recorded session into a new file. In this case, it does not derive events from the ticks,
  // because all events are given.
  bool rewrites = false;
  Lost lost_before;  // losses of the original recording, if the writer copies a recorded session
};

/// The state of the recording. `message` tells the user that an operation failed or that the disk is nearly full.
struct WriterStatus {
  enum class State { kRecording, kDiskLow, kDiskFull, kFailed, kFinished } state = State::kRecording;
  Lost lost;
  std::uint64_t ticks = 0, cuts = 0;  // number of rows in the file
  Nanos slowest_flush = 0;            // ns, elapsed time of the slowest write
  std::string message;
};

/// Writes one session file. Only one thread at a time may use it. The constructor throws Error if the file cannot be
/// created. The other functions never throw: data that a full or failing disk loses is counted in status(), and the
/// session continues.
class SessionWriter {
 public:
  SessionWriter(const std::filesystem::path& file, const SessionHeader& header, const WriterOptions& options = {});
  ~SessionWriter();  // writes all buffered data, but leaves the recording unfinished, as if the process were killed
  SessionWriter(const SessionWriter&) = delete;
  SessionWriter& operator=(const SessionWriter&) = delete;

  // Appends ticks. The cut and the patch (tissue copy) whose numbers a tick contains must be appended before this tick.
  // So the file is always complete up to its last tick.
  void append(std::span<const ServoTick> ticks) noexcept;
  void append(std::span<const Cut> cuts) noexcept;
  void append(std::span<const PatchUse> patches) noexcept;
  void append(const SessionEvent& event) noexcept;
  void event(Nanos t, EventKind kind, std::string_view text) noexcept;
  /// Sets the timing of the servo loop up to now. The next flush writes it.
  void loop(const LoopReport& report) noexcept;
  /// Appends one sample to the stream header.streams[stream], with one value for each column of the stream.
  void append(std::size_t stream, Nanos t, std::span<const double> values) noexcept;

  /// Sets how many values the queues have dropped in total (Ring::dropped()). The file stores these numbers.
  void count_ring_losses(std::uint64_t ticks, std::uint64_t cuts, std::uint64_t other) noexcept;

  /// Writes data that is older than the flush interval. Call at least every 100 ms.
  void heartbeat() noexcept;
  /// Writes all data so far. When the function returns, the operating system has the data.
  void flush() noexcept;
  /// Writes the remaining data and the result, and closes the file. Returns false if data is missing in the file (see
  /// status()).
  bool finish(const SessionResult& result) noexcept;

  const WriterStatus& status() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::session
