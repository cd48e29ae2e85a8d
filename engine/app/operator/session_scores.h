// The scores of the sessions in the list. They are cached between runs; missing ones are computed while the list is
// shown. Main thread only.
#pragma once

#include <filesystem>
#include <optional>
#include <set>

#include "engine/app/cases/mastery.h"
#include "engine/app/operator/archive.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"
#include "engine/session/score.h"
#include "engine/session/session_file.h"

namespace typodont {

/// The cached score; empty if the session's file or the program has changed since, or no score was cached.
std::optional<CachedScore> cached_score(const std::filesystem::path& session);
/// Stores a score in the cache. Any thread.
void cache_score(const std::filesystem::path& session, const CachedScore& score);
CachedScore known(const session::SessionReader& session, const session::Score& score);
/// Computes a score in a separate process, so that a damaged file cannot affect this one, and stores it in the cache.
/// `nice`: 0 to 19. Any thread. Throws Cancelled, Error or RunFailure.
CachedScore score_apart(const std::filesystem::path& session, Progress& progress, int nice = 0);
/// The scored sessions of the folder in order of time, only the newest if there are many. Computes missing scores;
/// leaves out unreadable files with a message. `progress`: null leaves out sessions without a cached score. Throws
/// Cancelled.
std::vector<PastSession> past_sessions(const SkillTable& table, const std::filesystem::path& folder,
                                       Progress* progress);
/// Levels of the scene's warnings for a trainee (empty: a guest), from the cached scores of the recorded sessions.
/// Throws Error.
session::WarningLevels warning_levels(const Scene& scene, const std::string& trainee);

class SessionScores {
 public:
  explicit SessionScores(OperatorState& s) : s_(s) {}

  /// Computes the next missing score in the background, newest session first. True: a computation has ended.
  bool look();
  /// Cancels the computation.
  void drop() { job_.drop(); }

 private:
  OperatorState& s_;
  std::set<std::filesystem::path> tried_;  // sessions whose computation was already started
  Job job_;
};

}  // namespace typodont
