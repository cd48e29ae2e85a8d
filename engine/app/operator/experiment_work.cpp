#include <fmt/format.h>

#include <limits>
#include <memory>

#include "engine/app/assets.h"
#include "engine/app/operator/child.h"
#include "engine/app/operator/library.h"
#include "engine/app/operator/session_works.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/json.h"
#include "engine/base/log.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

FoundValue value_in(const Json& json) {
  const auto number = [&](const char* key) {
    return json[key].is_number() ? json[key].number() : std::numeric_limits<double>::quiet_NaN();
  };
  return {number("value"), number("low"), number("high")};
}

/// Reads the output of `typodont experiment --json`.
void read_result(const Json& json, ExperimentFinding& found) {
  found.trials = static_cast<int>(json["trials"].integer(0));
  if (found.question == kModelQuestion) {
    for (std::size_t i = 0; i < 2; ++i) found.models[i] = json["models"].items().at(i).string();
    found.found = value_in(json["chosen_percent"]);
    found.chance = json["chance"].number(0, 1);
  } else {
    found.right = json["right_percent"].number(0, 100);
    found.found = value_in(json[json.has("jnd_ms") ? "jnd_ms" : "jnd_percent"]);
  }
}

}  // namespace

void make_experiment(OperatorState& s, BackgroundTask& work) {
  const ExperimentForm& form = s.experiment;
  const auto found = std::make_shared<ExperimentFinding>();
  found->person = s.trainee.data();
  found->question = static_cast<std::size_t>(form.question);
  const std::string question = kExperimentQuestions.at(found->question), who = file_name_of(found->person);
  const fs::path folder = user_folder() / "experiments" / (who.empty() ? "guest" : who);
  make_folder(folder);
  found->log = folder / fmt::format("{}_{}.csv", date_and_time(), question);
  found->page = fs::path(found->log).replace_extension(".html");

  const HandEntry& hand = s.hands.at(static_cast<std::size_t>(s.hand));
  const RigChoice& rig = s.rigs.at(static_cast<std::size_t>(s.rig));
  std::vector<std::string> words = {"experiment", s.scenes.at(static_cast<std::size_t>(s.scene)).file.string(),
                                    "--question", question,
                                    "--trials",   fmt::format("{}", form.trials.at(found->question)),
                                    "--seconds",  fmt::format("{:g}", form.seconds),
                                    "--hand",     hand.address.empty() ? s.address.data() : hand.address,
                                    "--out",      found->log.string(),
                                    "--page",     found->page.string(),
                                    "--language", std::string(session::tag_of(s.language)),
                                    "--json"};
  if (!found->person.empty()) words.insert(words.end(), {"--subject", found->person});
  if (found->question == kModelQuestion)
    words.insert(words.end(), {"--models", s.models.at(static_cast<std::size_t>(form.models[0])),
                               s.models.at(static_cast<std::size_t>(form.models[1]))});
  // Without a selected rig file, the separate process uses the scene's usual rig, because it can't draw in this window.
  if (!rig.file.empty()) words.insert(words.end(), {"--rig", rig.file.string()});
  if (s.no_real_time) words.emplace_back("--no-real-time");
  s.experiment_found.reset();
  work.begin(
      [words, found](Progress& progress) {
        progress.stage("op.experiment_runs");
        read_result(Json::parse(run_self(words, progress), "experiment"), *found);
        progress.at(1);
      },
      [&s, found] {
        s.experiment_found = *found;
        s.say(fmt::format("{} {}", s.text("op.written"), found->page.string()));
        log::info("experiment ended: {}", found->log.string());
      });
  log::info("experiment started: {}", question);
}

}  // namespace typodont
