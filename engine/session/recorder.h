// Written while the session runs, by the recorder thread: append() from its queues, heartbeat() often. A killed process
// loses half a second. SWMR: other processes can read after every flush. Layout: docs/session_format.md.
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
  // ns, longest time in memory only, with heartbeat()
  Nanos flush_interval = kNanosPerSecond / 2;
  int deflate = 3;  // deflate, 1..9
  // Free bytes: below `disk_needed` the constructor throws Error, below `disk_low` there is a warning, below
  // `disk_reserve` (about two flushes with journal) rows are lost and counted.
  std::uint64_t disk_needed = 16u << 20, disk_low = 64u << 20, disk_reserve = 4u << 20;
  std::function<std::uint64_t()> free_bytes;  // bytes; empty: asks the file system
  // A temporary name until start(): only a session that runs replaces an older recording.
  bool named_by_start = false;
  // A temporary file that finish() renames. For results, not for live sessions.
  bool whole_or_nothing = false;
  // Copies a recording: events are given, not derived from ticks.
  bool rewrites = false;
  Lost lost_before;  // of the copied recording
};

/// `message`: for the user, after a failure or near the disk's end.
struct WriterStatus {
  enum class State { kRecording, kDiskLow, kDiskFull, kFailed, kFinished } state = State::kRecording;
  Lost lost;
  std::uint64_t ticks = 0, cuts = 0;  // number of rows in the file
  Nanos slowest_flush = 0;            // ns, elapsed time of the slowest write
  std::string message;
};

/// One thread at a time. The noexcept functions count losses in status(), and the session goes on; without memory, the
/// recording ends. The constructor throws Error.
class SessionWriter {
 public:
  SessionWriter(const std::filesystem::path& file, const SessionHeader& header, const WriterOptions& options = {});
  ~SessionWriter();  // writes what is buffered; unfinished, as after a kill
  SessionWriter(const SessionWriter&) = delete;
  SessionWriter& operator=(const SessionWriter&) = delete;

  /// Gives the file its name, with named_by_start. Throws Error.
  void start();

  // A tick's cut and patch come first, so the file is complete up to its last tick.
  void append(std::span<const ServoTick> ticks) noexcept;
  void append(std::span<const Cut> cuts) noexcept;
  void append(std::span<const PatchUse> patches) noexcept;
  void append(const SessionEvent& event) noexcept;
  void event(Nanos t, EventKind kind, std::string_view text) noexcept;
  /// Of the servo loop so far, for the next flush.
  void loop(const LoopReport& report) noexcept;
  /// To header.streams[stream], a value per column.
  void append(std::size_t stream, Nanos t, std::span<const double> values) noexcept;

  /// Total drops of the queues (Ring::dropped()).
  void count_ring_losses(std::uint64_t ticks, std::uint64_t cuts, std::uint64_t other) noexcept;

  /// What is older than the flush interval. At least every 100 ms.
  void heartbeat() noexcept;
  /// All so far; the operating system then has it.
  void flush() noexcept;
  /// The rest and the result. False: data is missing (status()).
  bool finish(const SessionResult& result) noexcept;

  const WriterStatus& status() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::session
