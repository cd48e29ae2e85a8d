// Reads a recorded session, even one that was cut off by a crash or is still being recorded.
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

/// One recorded stream, as columns.
struct StreamData {
  std::vector<Nanos> t;
  std::vector<std::vector<double>> columns;  // the columns have the order of StreamSpec::columns
};

/// Reads one session file. Opening throws Error for a file that is not a readable session, that refers to other
/// files, or that contains impossible values (format/checks.h). The intact part of an opened file can be read, even
/// with gaps. Hand pose, pedal, force, quaternions, cuts and patches are returned bit for bit as they were written.
/// Columns in units other than SI (tool_x_mm …) are exact to one unit in the last place.
class SessionReader {
 public:
  explicit SessionReader(const std::filesystem::path& file);
  ~SessionReader();
  SessionReader(SessionReader&&) noexcept;
  SessionReader& operator=(SessionReader&&) noexcept;

  const std::filesystem::path& file() const;
  const SessionHeader& header() const;
  /// True if the recording was not finished: a crash, a kill, a truncated copy, or an active writer.
  bool truncated() const;
  /// True if another process is recording into this file now.
  bool being_recorded() const;
  const Lost& lost() const;
  /// Gaps in the middle of the recording, in order of time. The data before and after a gap is available.
  const std::vector<Gap>& gaps() const;

  std::uint64_t tick_count() const;
  /// Rows [first, first + count), limited to the existing rows. Throws Error if these rows are damaged.
  std::vector<ServoTick> ticks(std::uint64_t first, std::uint64_t count) const;
  std::vector<ServoTick> ticks() const { return ticks(0, tick_count()); }
  const std::vector<Cut>& cuts() const;
  const std::vector<PatchUse>& patches() const;
  const std::vector<SessionEvent>& events() const;
  const std::vector<StreamData>& streams() const;  // the streams have the order of header().streams
  const std::optional<SessionResult>& result() const;
  /// Recorded timing of the servo loop; no value for a session that did not run live.
  const std::optional<LoopReport>& loop() const;

 private:
  friend bool repair_session(const std::filesystem::path& file);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Converts a session that was cut off into an ordinary file that every HDF5 program can open; the session stays
/// `truncated`. Returns true if the file was rewritten, false if it was intact or is still being recorded. The file
/// is replaced completely or not at all. Throws Error if the file cannot be read or written.
bool repair_session(const std::filesystem::path& file);

}  // namespace typodont::session
