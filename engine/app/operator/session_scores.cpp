#include "engine/app/operator/session_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/app/operator/child.h"
#include "engine/base/cache.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/log.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

constexpr const char* kSuffix = ".json";
// Maximum score cache size, bytes: about ten thousand scores.
constexpr std::uintmax_t kMaxKept = 4 << 20;

/// Key of a score in the cache. It changes if the session's file or the program changes.
std::optional<std::uint64_t> key_of(const fs::path& session) {
  Sha256 key;
  cache::add_build(key);
  if (!cache::add_file(key, session)) return std::nullopt;
  return key.key();
}

}  // namespace

CachedScore known(const session::Score& score) {
  return {score.points, score.counts(), score.counts() && score.passed()};
}

std::optional<CachedScore> cached_score(const fs::path& session) {
  const fs::path folder = cache::folder("scores");
  const auto key = key_of(session);
  if (folder.empty() || !key) return std::nullopt;
  const fs::path file = cache::find(folder, *key, kSuffix);
  if (file.empty()) return std::nullopt;
  try {
    const Json json = Json::load(file);
    return CachedScore{json["points"].number(), json["counts"].boolean(), json["passed"].boolean()};
  } catch (const Error&) {  // the cached file of another version is ignored
    return std::nullopt;
  }
}

void cache_score(const fs::path& session, const CachedScore& score) {
  const fs::path folder = cache::folder("scores");
  const auto key = key_of(session);
  if (folder.empty() || !key) return;
  const nlohmann::json json = {{"points", score.points}, {"counts", score.counts}, {"passed", score.passed}};
  cache::keep(folder, *key, kSuffix, kMaxKept,
              [&](const fs::path& part) { write_file_atomically(part, json.dump() + "\n", FileKind::kJson); });
}

bool SessionScores::look() {
  if (!job_) {
    begin();
    return false;
  }
  if (!job_->done()) return false;
  const bool made = !job_->failure();
  job_.reset();
  if (!made) return false;
  const auto score = cached_score(scored_);
  for (SessionEntry& entry : s_.sessions)
    if (entry.file == scored_) entry.score = score;
  if (score) log::info("score of {}: {:.1f}", scored_.filename().string(), score->points);
  return score.has_value();
}

void SessionScores::begin() {
  const auto entry = std::find_if(s_.sessions.begin(), s_.sessions.end(), [&](const SessionEntry& one) {
    return one.recorded && !one.score && !tried_.contains(one.file);
  });
  if (entry == s_.sessions.end()) return;
  scored_ = entry->file;
  tried_.insert(scored_);
  job_ = std::make_unique<Job>([file = scored_](Progress& progress) {
    const Json json = Json::parse(
        run_self({"report", file.string(), "--json", "--out", "/dev/null"}, progress, kLowestPriority), "report");
    cache_score(file, {json["points"].number(), json["full"].number() > 0, json["passed"].boolean()});
  });
}

}  // namespace typodont
