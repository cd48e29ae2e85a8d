// Writes a session to disk while it runs. The app's recorder thread owns the writer, empties the rings into append()
// and calls heartbeat() often. Killed at any moment, the file keeps everything up to half a second ago and opens.
//
// The file is HDF5 in single-writer-multiple-readers mode: every flush leaves it readable, so another process can also
// watch a session that is being recorded. The layout is docs/session_format.md.
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
  Nanos flush_interval = kNanosPerSecond / 2;  // nothing older than this stays in memory (heartbeat)
  int deflate = 3;                             // 1..9; bytes are shuffled before, which is where most is won
  // Free bytes of the disk. What is needed to begin: less is an Error. Below `disk_low` the status says so. Below
  // `disk_reserve`, about two flushes with their journal, rows are counted instead of written.
  std::uint64_t disk_needed = 16u << 20, disk_low = 64u << 20, disk_reserve = 4u << 20;
  std::function<std::uint64_t()> free_bytes;  // what is left on the disk; empty: the file system is asked
  bool whole_or_nothing = false;  // write beside FILE and rename in finish(); for results, not for live sessions
  bool rewrites = false;          // a recorded session: all its events are given, so none is made of its ticks
  Lost lost_before;               // the same: to start counting from
};

/// How the recording fares. `message` says in words what was refused, once it was, and that the disk fills up.
struct WriterStatus {
  enum class State { kRecording, kDiskLow, kDiskFull, kFailed, kFinished } state = State::kRecording;
  Lost lost;
  std::uint64_t ticks = 0, cuts = 0;  // safely handed to the file
  Nanos slowest_flush = 0;            // wall time of the slowest write so far
  std::string message;
};

/// One thread at a time. The constructor throws Error when the file cannot be made; afterwards nothing throws: a disk
/// that fills up or fails is counted in status(), and the session goes on.
class SessionWriter {
 public:
  SessionWriter(const std::filesystem::path& file, const SessionHeader& header, const WriterOptions& options = {});
  ~SessionWriter();  // like a kill, but everything buffered is written first
  SessionWriter(const SessionWriter&) = delete;
  SessionWriter& operator=(const SessionWriter&) = delete;

  // Patches and cuts before the ticks that name them: what is on disk is then complete as far as its ticks go.
  void append(std::span<const ServoTick> ticks) noexcept;
  void append(std::span<const Cut> cuts) noexcept;
  void append(std::span<const PatchUse> patches) noexcept;
  void append(const SessionEvent& event) noexcept;
  void event(Nanos t, EventKind kind, std::string_view text) noexcept;
  /// How the servo's loop fared so far; the newest counts, and is in the file with the next flush.
  void loop(const LoopReport& report) noexcept;
  /// One sample of header.streams[stream]; as many values as it has columns.
  void append(std::size_t stream, Nanos t, std::span<const double> values) noexcept;

  /// Totals of what the rings had no room for (Ring::dropped()); they are written into the file.
  void count_ring_losses(std::uint64_t ticks, std::uint64_t cuts, std::uint64_t other) noexcept;

  /// Call at least every 100 ms: writes what has waited longer than the flush interval.
  void heartbeat() noexcept;
  /// Everything given so far is in the file (in the system's hands) when it returns.
  void flush() noexcept;
  /// The end: writes the rest and the result, closes the file. False when something is missing (see status()).
  bool finish(const SessionResult& result) noexcept;

  const WriterStatus& status() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::session
