// Writes a session file while the session runs. The recorder thread calls append() with the data of its queues, and
// heartbeat() often. If the process is killed, half a second is lost. Other processes can read the file after every
// flush (SWMR). Format: docs/session_format.md.
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
  // Longest time that data is only in memory if heartbeat() is called often, ns.
  Nanos flush_interval = kNanosPerSecond / 2;
  int deflate = 3;  // compression level of HDF5's filter deflate, 1 to 9
  // Free space on the disk, bytes: below `disk_needed` the constructor throws Error; below `disk_low` there is a
  // warning; below `disk_reserve` (about two flushes with journal) rows are lost and counted.
  std::uint64_t disk_needed = 16u << 20, disk_low = 64u << 20, disk_reserve = 4u << 20;
  std::function<std::uint64_t()> free_bytes;  // returns the free space, bytes; empty: asks the file system
  // True: the file has a temporary name until start(), so that only a started session replaces an older recording.
  bool named_by_start = false;
  // True: the file has a temporary name until finish(). For computed results, not for live sessions.
  bool whole_or_nothing = false;
  // True: copies a recording. The caller passes the events; otherwise the events are derived from the ticks.
  bool rewrites = false;
  Lost lost_before;  // losses of the recording that is copied
};

/// State of the recording. `message` is for the user, after a failure or if the disk is almost full.
struct WriterStatus {
  enum class State { kRecording, kDiskLow, kDiskFull, kFailed, kFinished } state = State::kRecording;
  Lost lost;
  std::uint64_t ticks = 0, cuts = 0;  // numbers of rows of ticks and of cuts in the file
  Nanos slowest_flush = 0;            // ns, elapsed time of the slowest write
  std::string message;
};

/// Writes one recording; one thread at a time. The noexcept functions count losses in status(), and the session
/// continues. If memory runs out, the recording ends. The constructor throws Error.
class SessionWriter {
 public:
  SessionWriter(const std::filesystem::path& file, const SessionHeader& header, const WriterOptions& options = {});
  ~SessionWriter();  // writes the buffered rows; without finish(), the file is unfinished, as after a kill
  SessionWriter(const SessionWriter&) = delete;
  SessionWriter& operator=(const SessionWriter&) = delete;

  /// Gives the file its final name if WriterOptions::named_by_start is set. Throws Error.
  void start();

  // Callers append a tick's cut and its change of the tissue patch first, then the tick itself. So the file is complete
  // up to its last tick.
  void append(std::span<const ServoTick> ticks) noexcept;
  void append(std::span<const Cut> cuts) noexcept;
  void append(std::span<const PatchUse> patches) noexcept;
  void append(const SessionEvent& event) noexcept;
  void event(Nanos t, EventKind kind, std::string_view text) noexcept;
  /// The servo loop's timing so far; written by the next flush.
  void loop(const LoopReport& report) noexcept;
  /// Appends a row to header.streams[stream], one value for each column.
  void append(std::size_t stream, Nanos t, std::span<const double> values) noexcept;

  /// Sets how many values the queues dropped (Ring::dropped()).
  void count_ring_losses(std::uint64_t ticks, std::uint64_t cuts, std::uint64_t other) noexcept;

  /// Writes rows that are older than the flush interval. Call at least every 100 ms.
  void heartbeat() noexcept;
  /// Passes all rows so far to the operating system.
  void flush() noexcept;
  /// Writes remaining rows and the result. False: data is missing (status()).
  bool finish(const SessionResult& result) noexcept;

  const WriterStatus& status() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::session
