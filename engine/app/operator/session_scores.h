// What recorded sessions scored, for their list: kept between runs, and worked out for the rest one after another while
// the list is looked at. Main thread.
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

/// As it was kept for this file and this program; nothing where it has to be worked out.
std::optional<KnownScore> kept_score(const std::filesystem::path& session);
/// For the next time it is looked at. Any thread.
void keep_score(const std::filesystem::path& session, const KnownScore& score);
KnownScore known(const session::Score& score);

class SessionScores {
 public:
  explicit SessionScores(OperatorState& s) : s_(s) {}

  /// Works out the next one that is missing, the newest first. True when one has come.
  bool look();
  /// Stops doing so.
  void drop() { job_.reset(); }

 private:
  void begin();

  OperatorState& s_;
  std::unique_ptr<Job> job_;
  std::filesystem::path scored_;           // the session that is being scored
  std::set<std::filesystem::path> tried_;  // those that had their turn
};

}  // namespace typodont
