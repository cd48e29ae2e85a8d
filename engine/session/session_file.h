// Reads a recorded session back, also one that was cut off by a crash or is still being recorded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/contract/loop_timing.h"
#include "engine/session/session_data.h"

namespace typodont::session {

/// One stream, column by column.
struct StreamData {
  std::vector<Nanos> t;
  std::vector<std::vector<double>> columns;  // in the order of StreamSpec::columns
};

/// Opening throws Error for anything that is not a readable session, that reaches for other files, or that holds
/// impossible values (format/checks.h); what was opened reads as far as it is intact, also when it has gaps.
/// Hand pose, pedal, force, quaternions and all of cuts and patches come back bit for bit as they were written; columns
/// kept in another unit than SI (tool_x_mm …) within one unit in the last place.
class SessionReader {
 public:
  explicit SessionReader(const std::filesystem::path& file);
  ~SessionReader();
  SessionReader(SessionReader&&) noexcept;
  SessionReader& operator=(SessionReader&&) noexcept;

  const std::filesystem::path& file() const;
  const SessionHeader& header() const;
  /// True when the recording was not finished: a crash, a kill, a truncated copy, or a writer still at work.
  bool truncated() const;
  /// Another process is recording into this file now.
  bool being_recorded() const;
  const Lost& lost() const;
  /// Where ticks or cuts are missing in the middle, in the order of time. What is before and after is there.
  const std::vector<Gap>& gaps() const;

  std::uint64_t tick_count() const;
  /// Rows [first, first + count), clipped to what there is. Throws Error where they are damaged.
  std::vector<ServoTick> ticks(std::uint64_t first, std::uint64_t count) const;
  std::vector<ServoTick> ticks() const { return ticks(0, tick_count()); }
  const std::vector<Cut>& cuts() const;
  const std::vector<PatchUse>& patches() const;
  const std::vector<SessionEvent>& events() const;
  const std::vector<StreamData>& streams() const;  // parallel to header().streams
  const std::optional<SessionResult>& result() const;
  /// How the servo's loop fared, as far as it was recorded; nothing for sessions that did not run live.
  const std::optional<LoopReport>& loop() const;

 private:
  friend bool repair_session(const std::filesystem::path& file);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Makes a session that was cut off into an ordinary file that every HDF5 program opens; it stays `truncated`. Returns
/// true when the file was rewritten, false when it was in order or is still being recorded. Throws Error like the
/// reader, and when the place is not writable. The file is replaced whole or not at all.
bool repair_session(const std::filesystem::path& file);

}  // namespace typodont::session
