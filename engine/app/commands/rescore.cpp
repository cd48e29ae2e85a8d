// `typodont rescore`: scores all sessions of a school again, for example after a rule has changed.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/operator/child.h"
#include "engine/app/recording/replay.h"
#include "engine/app/review/session_report.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/partial_file.h"
#include "engine/base/progress.h"
#include "engine/session/score.h"
#include "engine/session/session_file.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
using Row = nlohmann::ordered_json;

struct RescoreOptions {
  std::string sessions, rules, out;
  int jobs = 0;
  bool json = false;
};

constexpr int kReads = 2;  // number of attempts for a session whose process crashed

/// Reads "task" and "score" of a scene file, which replace those of a recording. Empty: the recorded rules apply.
std::string rules_of(const std::string& file) {
  if (file.empty()) return {};
  const Json scene = Json::load(file);
  Row changes;
  for (const char* key : {"task", "score"}) {
    const auto rule = scene.find(key);
    changes[key] = rule ? Row::parse(rule->text()) : Row();
  }
  if (changes["task"].is_null() && changes["score"].is_null())
    throw Error(file, "", "a scene without rules", "\"task\" or \"score\"");
  return changes.dump();
}

/// Scores one session in this process.
Row score(const std::string& file, const std::string& rules) {
  const session::SessionReader reader(file);
  const session::SessionSummary s =
      rules.empty() ? summary_of(reader) : summary_of(reader, scene_with(reader, rules, "--rules"));
  Row items = Row::object();
  // NaN and infinity become null, because JSON has neither.
  for (const session::ScoreItem& item : s.score.items) items[item.name] = item.value;
  return {{"session", file},
          {"date", s.date},
          {"trainee", s.trainee},
          {"scene", s.scene},
          {"truncated", s.truncated},
          {"points", s.score.points},
          {"full", s.score.full},
          {"completion", s.score.completion},
          {"passed", s.score.counts() && s.score.passed()},
          {"items", std::move(items)}};
}

std::string text_of(const Row& row) {
  return row.dump(-1, ' ', false, Row::error_handler_t::replace);
}

/// Scores a session in a separate process, so that a crash does not affect the other sessions. Always returns a row; it
/// has the key "error" if the session cannot be scored. `rules`: a file.
Row score_safely(const std::string& file, const std::string& rules) {
  std::vector<std::string> words{"rescore", file, "--json"};
  if (!rules.empty()) words.insert(words.end(), {"--rules", rules});
  for (int i = 0; i < kReads; ++i) {
    try {
      Progress quiet;
      return Row::parse(run_self(words, quiet));
    } catch (const RunFailure& failure) {
      constexpr std::string_view kError = "error: ";
      const std::string_view said = failure.what();
      if (said.starts_with(kError)) return {{"session", file}, {"error", said.substr(kError.size())}};
      // A process that crashed or was killed has no such message: try again.
    }
  }
  return {{"session", file}, {"error", fmt::format("{}: its process died {} times", file, kReads)}};
}

std::vector<std::string> sessions_below(const std::string& folder) {
  std::vector<std::string> files;
  for (const fs::path& file : files_below(folder, ".h5")) files.push_back(file.string());
  if (files.empty()) throw Error(folder, "", "a folder without sessions", "sessions (.h5)");
  return files;
}

std::string cell_of(const Row& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  std::string text = value.get<std::string>();
  // A spreadsheet would execute a text that begins with one of these characters as a formula.
  if (!text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos) text.insert(0, 1, '\'');
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2) text.insert(at, 1, '"');
  return '"' + text + '"';
}

/// The table as CSV: one row per session, one column per score item.
std::string table_of(const std::vector<Row>& rows) {
  const std::vector<std::string> first{"session", "date", "trainee",    "scene",  "truncated",
                                       "points",  "full", "completion", "passed", "error"};
  std::set<std::string> items;
  for (const Row& row : rows) {
    if (!row.contains("items")) continue;
    for (const auto& [name, value] : row["items"].items()) items.insert(name);
  }
  std::string text;
  const auto cell = [&](const std::string& value) { text += (text.empty() || text.back() == '\n' ? "" : ",") + value; };
  for (const std::string& name : first) cell(name);
  for (const std::string& name : items) cell(name);
  text += '\n';
  for (const Row& row : rows) {
    // Writes the first cell; a comma precedes all others.
    text += cell_of(row["session"]);
    for (std::size_t i = 1; i < first.size(); ++i) text += ',' + (row.contains(first[i]) ? cell_of(row[first[i]]) : "");
    for (const std::string& name : items)
      text += ',' + (row.contains("items") && row["items"].contains(name) ? cell_of(row["items"][name]) : "");
    text += '\n';
  }
  return text;
}

void run(const RescoreOptions& options) {
  std::error_code code;
  const std::string rules = rules_of(options.rules);
  if (!fs::is_directory(options.sessions, code)) {
    const Row row = score(options.sessions, rules);
    if (!options.out.empty()) write_file_atomically(options.out, table_of({row}), FileKind::kTable);
    fmt::print("{}\n", options.json ? text_of(row)
                                    : fmt::format("{}: {:.1f} of {:.0f} points", options.sessions,
                                                  session::printed_points(row["points"].get<double>()),
                                                  row["full"].get<double>()));
    return;
  }
  const std::vector<std::string> files = sessions_below(options.sessions);
  if (!options.out.empty()) require_output(options.out, FileKind::kTable);
  std::vector<Row> rows(files.size());
  std::atomic<std::size_t> next{0};
  {
    Progress progress("sessions");
    const int most = options.jobs > 0 ? options.jobs : static_cast<int>(std::thread::hardware_concurrency());
    std::vector<std::jthread> workers;
    std::atomic<std::size_t> done{0};
    std::atomic<bool> cancelled{false};
    for (int i = 0; i < std::clamp(most, 1, static_cast<int>(files.size())); ++i) {
      workers.emplace_back([&] {
        for (std::size_t k; !cancelled && (k = next++) < files.size(); ++done) {
          try {
            rows[k] = score_safely(files[k], options.rules);
          } catch (const std::exception& e) {
            rows[k] = {{"session", files[k]}, {"error", e.what()}};
          }
        }
      });
    }
    try {
      while (done < files.size()) {
        progress.at(static_cast<double>(done) / static_cast<double>(files.size()));
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
    } catch (...) {  // also catches the exception that Ctrl-C throws
      cancelled = true;
      throw;
    }
  }
  std::size_t failed = 0;
  for (const Row& row : rows) {
    if (!row.contains("error")) continue;
    ++failed;
    log::warn("{}", row["error"].get<std::string>());
  }
  if (!options.out.empty()) write_file_atomically(options.out, table_of(rows), FileKind::kTable);
  if (options.json) {
    fmt::print("{}\n", text_of(Row(rows)));
  } else {
    fmt::print("{} sessions, {} of them cannot be scored\n", rows.size(), failed);
    if (!options.out.empty()) fmt::print("wrote {}\n", options.out);
  }
}

}  // namespace

void add_rescore_command(cli::Command& app) {
  cli::Command* command = app.add_command("rescore", "Score recorded sessions again, e.g. after a rule has changed");
  const auto options = std::make_shared<RescoreOptions>();
  command
      ->add_option("SESSIONS", options->sessions, "a folder of sessions, those in its folders included, or one session")
      ->required();
  command->add_option("--rules", options->rules, "a scene whose task or score counts instead of the recorded one");
  command->add_option("--out", options->out, "a table with one row a session (.csv)", cli::writes({FileKind::kTable}));
  command->add_option("--jobs", options->jobs, "sessions at once; otherwise as many as there are cores",
                      cli::from_zero());
  command->add_flag("--json", options->json, "print the rows as JSON");
  command->footer("Example: typodont rescore sessions/ --rules assets/scenes/class-2-cavity.json --out scores.csv");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
