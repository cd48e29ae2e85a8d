// Scores of the list, cached between runs; missing ones are computed while it is shown. Main thread only.
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

/// Empty if file or program have changed.
std::optional<CachedScore> cached_score(const std::filesystem::path& session);
/// Any thread.
void cache_score(const std::filesystem::path& session, const CachedScore& score);
CachedScore known(const session::Score& score);

class SessionScores {
 public:
  explicit SessionScores(OperatorState& s) : s_(s) {}

  /// The next missing one in the background, newest first. True: one was finished.
  bool look();
  /// Cancels.
  void drop() { job_.reset(); }

 private:
  void begin();

  OperatorState& s_;
  std::unique_ptr<Job> job_;
  std::filesystem::path scored_;           // the session whose score is computed at present
  std::set<std::filesystem::path> tried_;  // already started
};

}  // namespace typodont
