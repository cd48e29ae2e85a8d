#include "engine/app/operator/session_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/app/operator/child.h"
#include "engine/app/operator/library.h"
#include "engine/app/task/warnings.h"
#include "engine/base/cache.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/keys.h"
#include "engine/base/log.h"
#include "engine/session/score.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

constexpr const char* kScoreSuffix = ".json";
// Maximum score cache size, bytes: about ten thousand scores.
constexpr std::uintmax_t kMaxScores = 16 << 20;
// Number of sessions from which mastery is estimated. Older sessions would hardly change the estimate.
constexpr std::size_t kMaxPast = 200;

/// Key of a score in the cache. It changes if the session's file or the program changes.
std::optional<std::uint64_t> score_key(const fs::path& session) {
  Sha256 key;
  cache::add_build(key);
  if (!cache::add_file(key, session)) return std::nullopt;
  return key.key();
}

/// Reads a score from the JSON of `typodont report`, or from the cache, whose files have the same keys.
CachedScore score_from(const Json& json) {
  CachedScore score{json["points"].number(), json["full"].number() > 0, json["passed"].boolean(),
                    json["completion"].number(0, 1), json["date"].string()};
  for (const Json& item : json["items"].items())
    score.items.push_back({item["name"].string(), item["points"].number(), item["full"].number()});
  if (const Json made = json["case"]; made.is_object()) score.made = read_keys(made, describe_case);
  return score;
}

/// Days since 1970 of a date such as "2025-03-14T09:26:53Z"; empty if it is no date.
std::optional<double> day_of(const std::string& date) {
  std::tm time{};
  std::istringstream in(date);
  in >> std::get_time(&time, "%Y-%m-%dT%H:%M:%S");
  if (in.fail()) return std::nullopt;
  return static_cast<double>(timegm(&time)) / 86'400;
}

}  // namespace

CachedScore known(const session::SessionReader& session, const session::Score& score) {
  const session::SessionHeader& header = session.header();
  CachedScore known{score.points, score.counts(), score.counts() && score.passed(), score.completion, header.date};
  for (const session::ScoreItem& item : score.items) known.items.push_back({item.name, item.points, item.full});
  if (!header.scene_json.empty()) known.made = case_in(Json::parse(header.scene_json, "scene"));
  return known;
}

std::optional<CachedScore> cached_score(const fs::path& session) {
  const fs::path folder = cache::folder("scores");
  const auto key = score_key(session);
  if (folder.empty() || !key) return std::nullopt;
  const fs::path file = cache::find(folder, *key, kScoreSuffix);
  if (file.empty()) return std::nullopt;
  try {
    return score_from(Json::load(file));
  } catch (const Error&) {  // the cached file of another version is ignored
    return std::nullopt;
  }
}

void cache_score(const fs::path& session, const CachedScore& score) {
  const fs::path folder = cache::folder("scores");
  const auto key = score_key(session);
  if (folder.empty() || !key) return;
  nlohmann::json json = {{"points", score.points},
                         {"full", score.counts ? 100 : 0},
                         {"passed", score.passed},
                         {"completion", score.completion},
                         {"date", score.date},
                         {"case", nullptr},
                         {"items", nlohmann::json::array()}};
  if (score.made) json["case"] = json_of(*score.made);
  for (const ItemPoints& item : score.items)
    json["items"].push_back({{"name", item.name}, {"points", item.points}, {"full", item.full}});
  const std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  cache::keep(folder, *key, kScoreSuffix, kMaxScores,
              [&](const fs::path& part) { write_file_atomically(part, text, FileKind::kJson); });
}

CachedScore score_apart(const fs::path& session, Progress& progress, int nice) {
  const CachedScore score = score_from(Json::parse(
      run_self({"report", session.string(), "--json", "--out", "/dev/null"}, progress, nice), session.string()));
  cache_score(session, score);
  return score;
}

std::vector<PastSession> past_sessions(const SkillTable& table, const fs::path& folder, Progress* progress) {
  std::vector<fs::path> files = files_in(folder, ".h5");
  if (files.size() > kMaxPast) files.erase(files.begin(), files.end() - kMaxPast);
  std::vector<std::pair<std::string, PastSession>> dated;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (progress)
      progress->stage("op.scoring", static_cast<double>(i) / static_cast<double>(files.size()),
                      static_cast<double>(i + 1) / static_cast<double>(files.size()));
    try {
      auto score = cached_score(files[i]);
      if (!score && progress) score = score_apart(files[i], *progress);
      if (!score || !score->counts) continue;
      PastSession past{.day = day_of(score->date), .shares = shares_of(table, score->items, score->completion)};
      if (score->made)
        past.family = score->made->family, past.seed = score->made->seed, past.difficulty = score->made->difficulty;
      dated.push_back({score->date + files[i].filename().string(), std::move(past)});
    } catch (const Cancelled&) {
      throw;
    } catch (const std::exception& e) {
      log::warn("left out: {}: {}", files[i].string(), e.what());
    }
  }
  std::ranges::stable_sort(dated, {}, &std::pair<std::string, PastSession>::first);
  std::vector<PastSession> sessions;
  for (auto& [date, session] : dated) sessions.push_back(std::move(session));
  return sessions;
}

session::WarningLevels warning_levels(const Scene& scene, const std::string& trainee) {
  session::WarningLevels levels;
  if (!scene.needs("render")) return levels;
  for (const WarningRule& rule : warning_rules(scene)) levels[rule.item] = 1;
  if (levels.empty() || trainee.empty()) return levels;
  const SkillTable table = skill_table();
  const fs::path folder = user_folder() / "sessions" / file_name_of(trainee);
  const std::vector<Mastery> mastery = mastery_after(table, past_sessions(table, folder, nullptr));
  for (std::size_t i = 0; i < table.skills.size(); ++i)
    for (const std::string& item : table.skills[i].items)
      if (levels.contains(item)) levels[item] = warning_level(table.model, mastery[i]);
  return levels;
}

bool SessionScores::look() {
  if (job_.under_way()) return job_.look();
  const auto entry = std::ranges::find_if(
      s_.sessions, [&](const SessionEntry& one) { return one.recorded && !one.score && !tried_.contains(one.file); });
  if (entry == s_.sessions.end()) return false;
  tried_.insert(entry->file);
  job_.make([file = entry->file](Progress& progress) { return score_apart(file, progress, kLowestPriority); },
            [this, file = entry->file](const CachedScore& score) {
              for (SessionEntry& one : s_.sessions)
                if (one.file == file) one.score = score;
              log::info("score of {}: {:.1f}", file.filename().string(), session::printed_points(score.points));
            },
            [](const std::exception&) {});  // a session that cannot be scored has no score in the list
  return false;
}

}  // namespace typodont
