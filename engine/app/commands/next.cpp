// `typodont next`: chooses the next case for a trainee from the scores of recorded sessions.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/app/assets.h"
#include "engine/app/cases/next_case.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/operator/library.h"
#include "engine/app/operator/session_scores.h"
#include "engine/base/error.h"
#include "engine/base/log.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

struct NextOptions {
  std::string trainee, sessions, limits, out, language;
  bool json = false;
};

constexpr std::uint64_t kTries = 20;  // number of seeds that are tried until one gives a valid case

/// Makes the chosen case. Seeds that give no valid case are skipped.
void make(NextCase& next, const std::string& family, std::span<const PastSession> past, const NextOptions& options) {
  for (std::uint64_t n = 0;; ++n) {
    next.seed = new_seed(family, past, options.trainee, n);
    try {
      (void)make_case({{family, next.seed, next.difficulty}, ""}, options.out);
      return;
    } catch (const RunFailure& e) {
      if (n + 1 == kTries) throw;
      log::info("seed {} is refused: {}", next.seed, e.what());
    }
  }
}

void run(const NextOptions& options) {
  const session::Language language = user_language(options.language);
  const SkillTable table = skill_table();
  const std::vector<CaseFamily> families = case_families();
  const fs::path usual = user_folder() / "limits.json";
  std::error_code code;
  PathLimits limits;
  if (!options.limits.empty() || fs::exists(usual, code))
    limits = read_limits(options.limits.empty() ? usual : fs::path(options.limits), families);

  const std::string who = file_name_of(options.trainee);
  const fs::path folder = (options.sessions.empty() ? user_folder() / "sessions" : fs::path(options.sessions)) /
                          (who.empty() ? "guest" : who);
  if (!options.sessions.empty() && !fs::is_directory(options.sessions, code))
    throw Error("--sessions", "", options.sessions, "a folder with one folder of recordings for each trainee");
  std::optional<Progress> progress("next");
  const std::vector<PastSession> past = past_sessions(table, folder, &*progress);
  progress.reset();  // ends the progress line before other output
  const std::vector<Mastery> mastery = mastery_after(table, past);
  NextCase next = next_case(table, trained_by(table, families), limits, past, mastery, options.trainee);
  const CaseFamily& family = families[next.family];
  const Skill& skill = table.skills[next.skill];
  if (!options.out.empty()) make(next, family.name, past, options);

  const std::string title = family.title.in(language), difficulty = session::number_text(next.difficulty, 2, language);
  const std::string reason = past.empty()
                                 ? fmt::format(fmt::runtime(session::text("next.first", language)), title, difficulty)
                                 : fmt::format(fmt::runtime(session::text("next.weakest", language)), title, difficulty,
                                               skill.title.in(language), std::lround(100 * next.expected));
  const auto error = [&](std::size_t i) { return std::sqrt(mastery[i].variance); };
  if (options.json) {
    nlohmann::ordered_json json = {{"family", family.name},
                                   {"difficulty", next.difficulty},
                                   {"seed", next.seed},
                                   {"skill", skill.name},
                                   {"expected_share", next.expected},
                                   {"reason", reason},
                                   {"sessions", past.size()},
                                   {"skills", nlohmann::json::array()},
                                   {"out", options.out.empty() ? nlohmann::json() : nlohmann::json(options.out)}};
    for (std::size_t i = 0; i < mastery.size(); ++i)
      json["skills"].push_back({{"name", table.skills[i].name},
                                {"title", table.skills[i].title.in(language)},
                                {"ability", mastery[i].ability},
                                {"standard_error", error(i)},
                                {"sessions", mastery[i].sessions}});
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{}\n", reason);
  for (std::size_t i = 0; i < mastery.size(); ++i)
    if (mastery[i].sessions > 0)
      fmt::print("  {}: {:+.2f} ± {:.2f} logits, {} sessions\n", table.skills[i].title.in(language), mastery[i].ability,
                 error(i), mastery[i].sessions);
  if (options.out.empty())
    fmt::print("typodont case {} --seed {} --difficulty {:.2f} --out case.json\n", family.name, next.seed,
               next.difficulty);
  else
    fmt::print("wrote {}\n", options.out);
}

}  // namespace

void add_next_command(cli::Command& app) {
  auto options = std::make_shared<NextOptions>();
  cli::Command* command = app.add_command("next", "Choose the next case for a trainee from the recorded sessions");
  command->footer("Example:\n  typodont next --trainee Anna --out next.json");
  command->add_option("--trainee", options->trainee, "The trainee's name; without it, the guest");
  command->add_option("--sessions", options->sessions,
                      "The folder with one folder of recordings for each trainee; otherwise ~/Typodont/sessions");
  command->add_option("--limits", options->limits,
                      "A teacher's limits (JSON: families, min_difficulty, max_difficulty, in_order); otherwise "
                      "~/Typodont/limits.json if it exists");
  command->add_option("--out", options->out, "Make the case: scene to write, its volume beside it (.vdb)",
                      cli::writes({FileKind::kJson}));
  command->add_option("--language", options->language, "en, de or zh; otherwise the window's language");
  command->add_flag("--json", options->json, "Print the choice and the mastery of each skill as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
