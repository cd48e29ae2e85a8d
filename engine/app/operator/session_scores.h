// The scores in the list of recorded sessions. Scores are cached between runs of the program. Missing scores are
// computed one by one while the list is shown. Main thread only.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>

#include "engine/app/operator/archive.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"
#include "engine/session/score.h"

namespace typodont {

/// Returns the cached score of a session; empty if it must be computed because the file or the program has changed.
std::optional<CachedScore> cached_score(const std::filesystem::path& session);
/// Stores a score in the cache. For any thread.
void cache_score(const std::filesystem::path& session, const CachedScore& score);
CachedScore known(const session::Score& score);

class SessionScores {
 public:
  explicit SessionScores(OperatorState& s) : s_(s) {}

  /// Computes the next missing score in the background, the newest session first. Returns true if a score was finished
  /// since the last call.
  bool look();
  /// Cancels the computation of the sessions' scores.
  void drop() { job_.reset(); }

 private:
  void begin();

  OperatorState& s_;
  std::unique_ptr<Job> job_;
  std::filesystem::path scored_;           // the session whose score is computed at present
  std::set<std::filesystem::path> tried_;  // sessions for which the computation of the score was already started
};

}  // namespace typodont
