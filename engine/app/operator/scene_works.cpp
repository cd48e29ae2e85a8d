#include "engine/app/operator/scene_works.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <sstream>

#include "engine/app/operator/archive.h"
#include "engine/app/operator/child.h"
#include "engine/app/operator/exercise.h"
#include "engine/app/operator/library.h"
#include "engine/app/planning/planned_exercise.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "haptics/import/import.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

NewExercise exercise_of(const OperatorState& s, const Authored& authored) {
  const ExerciseForm& form = s.exercise;
  NewExercise made{.name = form.name.data(),
                   .goal = form.goal.data(),
                   .base = &authored.scene,
                   .strokes = authored.strokes,
                   .ideal = form.ideal == IdealFrom::kDrilled ? &authored.tissue : nullptr,
                   .ideal_mesh = form.ideal == IdealFrom::kMesh ? form.mesh.data() : "",
                   .mesh_unit_mm = static_cast<double>(form.mesh_unit_mm)};
  std::istringstream lines(form.steps.data());
  for (std::string line; std::getline(lines, line);)
    if (line.find_first_not_of(" \t") != std::string::npos) made.steps.push_back(line);
  for (std::size_t i = 1; i < kTissueCount; ++i) made.stiffness[i] = static_cast<double>(s.stiffness[i]);
  if (std::any_of(form.rules.begin(), form.rules.end(), [](const RuleChoice& r) { return r.counts; }))
    made.rules = form.rules;
  if (made.rules)
    for (RuleChoice& rule : *made.rules) rule.from_ideal = rule.from_ideal && form.aims();
  return made;
}

/// Inverse of joined_files(). A text that is no list of meshes is the name of a single file.
std::vector<fs::path> files_of(const std::string& text) {
  std::vector<fs::path> files;
  std::istringstream in(text);
  for (std::string file; std::getline(in, file, ';');) files.emplace_back(file);
  if (!files.empty() && std::ranges::all_of(files, haptics::is_mesh_file)) return files;
  return {text};
}

/// Starts a task that makes a scene. Afterwards the scene is in the list and selected, and a message tells the user.
void begin(OperatorState& s, BackgroundTask& work, Choices& choices, const char* text, const char* words,
           std::function<fs::path(Progress&)> make, std::function<void()> then = {}) {
  work.make(
      [make = std::move(make), language = s.language](Progress& progress) {
        try {
          return make(progress);
        } catch (const RuleRefused& refused) {
          // The message uses the rule's title on the page.
          const std::string name(session::text(fmt::format("score.{}", refused.rule), language));
          throw Error(fmt::format(
              fmt::runtime(session::text(refused.no_target ? "op.rule_no_target" : "op.rule_numbers", language)),
              name));
        }
      },
      [&s, &choices, text, words, then = std::move(then)](const fs::path& file) {
        if (then) then();
        choices.rescan();
        choices.choose_scene(file);
        s.say(fmt::format("{} {}", s.text(text), file.string()));
        log::info("{}: {}", words, file.string());
      });
}

}  // namespace

void begin_case(OperatorState& s, BackgroundTask& work, Choices& choices, bool next) {
  const fs::path folder = user_folder() / "scenes", file = folder / fmt::format("case_{}.json", date_and_time());
  make_folder(folder);
  const CaseForm& form = s.cases;
  std::vector<std::string> words{"case",         form.families.at(static_cast<std::size_t>(form.family)).first,
                                 "--seed",       std::to_string(form.seed),
                                 "--difficulty", fmt::format("{:.2f}", form.difficulty)};
  if (next) words = {"next", "--trainee", s.trainee.data(), "--language", std::string(session::tag_of(s.language))};
  words.insert(words.end(), {"--out", file.string(), "--json"});
  work.make(
      [words = std::move(words)](Progress& progress) {
        progress.stage("op.making_case");
        return Json::parse(run_self(words, progress), words.front()).string_or("reason", "");
      },
      [&s, &choices, file](const std::string& reason) {
        choices.rescan();
        choices.choose_scene(file);
        s.say(reason.empty() ? fmt::format("{} {}", s.text("op.exercise_saved"), file.string()) : reason);
        log::info("case made: {}", file.string());
      });
}

NewTooth tooth_of(const ImportForm& form) {
  NewTooth tooth;
  constexpr double kMouthOpen = 30e-3;  // m, distance by which the jaws are opened if several meshes are given
  const std::vector<fs::path> files = files_of(form.file.data());
  tooth.input = files[0];
  tooth.more.assign(files.begin() + 1, files.end());
  if (!tooth.more.empty()) tooth.open = kMouthOpen;
  tooth.name = form.name.data();
  tooth.crown = static_cast<Crown>(form.crown);
  tooth.as_scanned = form.preset == kScannedSurface;
  if (!tooth.as_scanned) tooth.options.preset = static_cast<haptics::ImportPreset>(form.preset);
  if (form.series > 0) tooth.options.series = form.series;
  if (form.voxel_mm > 0) tooth.options.voxel = static_cast<double>(form.voxel_mm) * kMillimetre;
  if (form.shell_mm > 0) tooth.options.shell = static_cast<double>(form.shell_mm) * kMillimetre;
  if (form.spacing_mm > 0) tooth.options.spacing = dvec3(static_cast<double>(form.spacing_mm) * kMillimetre);
  tooth.options.mesh_unit = static_cast<double>(form.unit_mm) * kMillimetre;
  return tooth;
}

void propose_name(OperatorState& s) {
  ImportForm& form = s.import;
  const fs::path file = files_of(form.file.data())[0];
  // The name of a DICOM file is not used, because it often contains a patient's name.
  std::string name = haptics::is_dicom(file) ? fmt::format("{} {}", s.text("op.scan"), date_and_time().substr(0, 10))
                                             : file.stem().string();
  name.resize(std::min(name.size(), form.name.size() - 1));
  form.name = {};
  name.copy(form.name.data(), name.size());
}

std::string joined_files(const std::vector<std::string>& files) {
  return fmt::format("{}", fmt::join(files, ";"));
}

bool take_dropped_mesh(OperatorState& s) {
  if (files_of(s.dropped).size() > 1 || !haptics::is_mesh_file(s.dropped) || s.dropped.size() >= s.fuse.file.size())
    return false;
  s.fuse.file = {};
  s.dropped.copy(s.fuse.file.data(), s.fuse.file.size() - 1);
  return true;
}

bool take_dropped(OperatorState& s) {
  ImportForm& form = s.import;
  const std::vector<fs::path> files = files_of(s.dropped);
  std::error_code code;
  if (s.dropped.empty() || s.dropped.size() >= form.file.size() || (files.size() == 1 && !fs::exists(files[0], code))) {
    s.fail(s.text("op.drop_one"));
    return false;
  }
  form = {};
  s.dropped.copy(form.file.data(), form.file.size() - 1);
  propose_name(s);
  if (files.size() > 1) form.preset = static_cast<int>(haptics::ImportPreset::kArch);
  s.say(s.text("op.dropped"));
  return !haptics::is_mesh_file(files[0]);
}

void import_reviewed(OperatorState& s, BackgroundTask& work, Choices& choices, const ScanReview& review) {
  NewTooth tooth = tooth_of(s.import);
  const haptics::ImportOptions options = review.options();
  const auto known = review.can_correct() ? std::make_shared<haptics::Imported>(*review.labels()) : nullptr;
  begin(s, work, choices, "op.imported", "imported",
        [tooth, options, known, scan = review.scan(), corrections = review.corrections()](Progress& progress) {
          progress.stage("op.importing", 0, 0.9);
          if (known) return write_exercise_of(tooth, std::move(*known), progress);
          haptics::ImportOptions watched = options;
          watched.progress = [&](double fraction) { progress.at(fraction); };
          haptics::Imported imported = scan->import(watched);
          for (const haptics::Correction& correction : corrections) (void)haptics::correct(imported, correction);
          return write_exercise_of(tooth, std::move(imported), progress);
        });
}

void import_tooth(OperatorState& s, BackgroundTask& work, Choices& choices) {
  begin(s, work, choices, "op.imported", "imported",
        [tooth = tooth_of(s.import), hint = std::string(s.text("op.try_surface"))](Progress& progress) {
          try {
            return import_tooth(tooth, progress);
          } catch (const Error& e) {
            if (tooth.as_scanned || !haptics::is_mesh_file(tooth.input)) throw;
            // The mesh is not closed, as is common for scans: adds a hint to the message.
            throw Error(fmt::format("{}. {}", e.what(), hint));
          }
        });
}

void save_exercise(OperatorState& s, BackgroundTask& work, Choices& choices, Authored& authored) {
  begin(
      s, work, choices, "op.exercise_saved", "exercise saved",
      [made = exercise_of(s, authored)](Progress& progress) { return write_exercise(made, progress); },
      [&authored] { authored.unsaved = false; });
}

void save_plan(OperatorState& s, BackgroundTask& work, Choices& choices) {
  const PlanForm& form = s.plan;
  if (!form.planner) return;
  begin(
      s, work, choices, "op.exercise_saved", "plan saved",
      [name = std::string(form.name.data()), plan = form.plan,
       procedure = form.procedures[static_cast<std::size_t>(form.procedure)], planner = form.planner,
       leaves = s.text("op.plan_leaves"), language = s.language](Progress& progress) {
        progress.stage("op.saving_exercise");
        // The page may show the findings of an earlier plan.
        if (const PlanFindings found = planner->findings(plan); !found.fits())
          throw RunFailure(
              fmt::format("{} {} mm", leaves, session::number_text(found.leaves_depth / kMillimetre, 1, language)));
        const fs::path folder = user_folder() / "scenes", file = folder / (file_name_of(name) + ".json");
        make_folder(folder);
        write_planned_exercise({name, planner.get(), procedure, plan}, file, Over::kItsInput, progress);
        return file;
      },
      [&s] { s.page = Page::kStart; });
}

fs::path keep_exercise(const OperatorState& s, const Authored& authored) {
  NewExercise made = exercise_of(s, authored);
  made.name = fmt::format("{} {}", authored.scene.name, date_and_time());
  // Leaves out the form's mesh and rules, because an invalid entry must not prevent saving.
  made.ideal = &authored.tissue;
  made.ideal_mesh.clear();
  made.rules.reset();
  Progress unwatched;
  return write_exercise(made, unwatched);
}

}  // namespace typodont
