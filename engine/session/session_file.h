// Reads a recorded session. The recording may have been cut off by a crash, or may not be finished yet.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/contract/loop_timing.h"
#include "engine/session/opened_session.h"
#include "engine/session/session_data.h"

namespace typodont::session {

/// A recorded stream. The values are stored by column.
struct StreamData {
  std::vector<Nanos> t;
  std::vector<std::vector<double>> columns;  // the columns have the order of StreamSpec::columns
};

/// Reads one session file, also the intact part of a damaged one. The constructor throws Error if the file is no
/// readable session, refers to other files, or contains impossible values (format/checks.h). Hand pose, pedal, force,
/// quaternions, cuts and numbers of tissue patches keep their bits; columns in mm or other units than SI differ by at
/// most one unit in the last place.
class SessionReader {
 public:
  explicit SessionReader(const OpenedSession& session);
  explicit SessionReader(const std::filesystem::path& file) : SessionReader(OpenedSession(file)) {}
  ~SessionReader();
  SessionReader(SessionReader&&) noexcept;
  SessionReader& operator=(SessionReader&&) noexcept;

  const std::filesystem::path& file() const { return contents_.file; }
  const SessionHeader& header() const { return contents_.header; }
  /// True if the recording was not finished. The causes are a crash, a kill, an incomplete copy, or a recording that
  /// still runs.
  bool truncated() const { return contents_.truncated; }
  /// True if another process is writing this file now.
  bool being_recorded() const { return contents_.being_recorded; }
  const Lost& lost() const { return contents_.lost; }
  /// The gaps in the recording, in order of time. The data before and after each gap can be read.
  const std::vector<Gap>& gaps() const { return contents_.gaps; }

  std::uint64_t tick_count() const;
  /// Returns `count` ticks from row `first`, or fewer if the file has fewer rows. Throws Error if these rows are
  /// damaged.
  std::vector<ServoTick> ticks(std::uint64_t first, std::uint64_t count) const;
  std::vector<ServoTick> ticks() const { return ticks(0, tick_count()); }
  /// Calls use(ticks) with one piece of the ticks after the other, so that memory does not grow with the session's
  /// length. Throws Error like ticks().
  template <class Use>
  void each_piece(const Use& use) const {
    constexpr std::uint64_t kPiece = 8192;  // number of ticks
    for (std::uint64_t first = 0; first < tick_count(); first += kPiece) use(ticks(first, kPiece));
  }
  const std::vector<Cut>& cuts() const { return contents_.cuts; }
  const std::vector<PatchUse>& patches() const { return contents_.patches; }
  const std::vector<SessionEvent>& events() const { return contents_.events; }
  /// The streams have the order of header().streams.
  const std::vector<StreamData>& streams() const { return contents_.streams; }
  /// The stream of this name; null if the recording has none.
  const StreamData* stream(std::string_view name) const;
  const std::optional<SessionResult>& result() const { return contents_.result; }
  /// The timing of the servo loop; no value if the session did not run live.
  const std::optional<LoopReport>& loop() const { return contents_.loop; }

 private:
  friend bool repair_session(const std::filesystem::path& file);
  /// Everything that the file contains, except the ticks.
  struct Contents {
    std::filesystem::path file;
    SessionHeader header;
    bool truncated = false, being_recorded = false;
    Lost lost;
    std::vector<Cut> cuts;
    std::vector<PatchUse> patches;
    std::vector<SessionEvent> events;
    std::vector<StreamData> streams;
    std::optional<SessionResult> result;
    std::optional<LoopReport> loop;
    std::vector<Gap> gaps;
  };
  struct Impl;
  Contents contents_;
  std::unique_ptr<Impl> impl_;
};

/// Recovers an unsigned recording whose program was killed or lost power. Writes the recording again, with the
/// changes of its journal, as an ordinary file that every HDF5 program can open. Replaces the old file completely or
/// not at all; the new file remains marked as truncated. False if the file is intact or is still being recorded.
/// Throws Error if the file is signed, or cannot be read or written.
bool repair_session(const std::filesystem::path& file);

}  // namespace typodont::session
