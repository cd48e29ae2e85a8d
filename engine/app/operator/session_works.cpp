#include "engine/app/operator/session_works.h"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <memory>
#include <utility>

#include "engine/app/assets.h"
#include "engine/app/operator/archive.h"
#include "engine/app/operator/child.h"
#include "engine/app/operator/library.h"
#include "engine/app/operator/session_scores.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/review/session_report.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/partial_file.h"
#include "engine/session/result_model.h"
#include "engine/session/session_file.h"
#include "engine/surface/mesh_export.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

std::shared_ptr<const SessionResult> pictured_result(session::Score score, const session::ReportOptions& report) {
  return std::make_shared<const SessionResult>(
      SessionResult{std::move(score), picture_of_result(report), report.ideal.has_value()});
}

/// Starts a task that writes `file`, a film for example, and then tells the user. `opens`: also opens the file.
void make_file(OperatorState& s, BackgroundTask& work, const char* what, const fs::path& file, bool opens,
               std::function<void(Progress&)> write) {
  work.begin(std::move(write), [&s, what, file, opens] {
    s.say(fmt::format("{} {}", s.text("op.written"), file.string()));
    log::info("{} written: {}", what, file.string());
    if (opens) s.to_open.push_back(file.string());
  });
}

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

render::Picture picture_of_result(const session::ReportOptions& report) {
  if (!report.result) return {};
  constexpr glm::ivec2 kPixels{560, 420};
  constexpr glm::vec3 kGround(32, 32, 33);  // sRGB, background colour of the panels
  const session::ModelView view =
      session::angled_view(report.preparation ? report.preparation->axis_W : dvec3(0, 0, 1));
  const bool compared = report.ideal.has_value();
  const std::vector<std::uint8_t> rgb = session::draw_model_pixels(*report.result, view, kPixels, compared, kGround);
  render::Picture picture{kPixels, {}};
  picture.rgba.reserve(rgb.size() / 3 * 4);
  for (std::size_t i = 0; i < rgb.size(); i += 3)
    picture.rgba.insert(picture.rgba.end(), {rgb[i], rgb[i + 1], rgb[i + 2], 255});
  return picture;
}

void list_sessions(OperatorState& s) {
  s.sessions = find_sessions();
  for (SessionEntry& entry : s.sessions)
    for (const SceneChoice& choice : s.scenes)
      if (file_name_of(choice.name) == entry.scene) entry.title = choice.title;
}

void make_report(OperatorState& s, BackgroundTask& work, const fs::path& recording, std::function<void()> then) {
  const fs::path report = fs::path(recording).replace_extension(".html");
  work.make(
      [recording, report, language = s.language](Progress& progress) {
        progress.stage("op.making_report", 0, 0.6);
        const session::SessionReader reader(recording);
        progress.at(0.2);
        session::ReportOptions options = report_of(reader);
        options.language = language;
        if (!options.score) options.score = session::score_session(reader);
        auto made = pictured_result(*options.score, options);
        cache_score(recording, known(reader, made->score));
        progress.stage("op.making_report", 0.6, 1);
        options.earlier = earlier_sessions(recording.parent_path(), reader);
        options.expert = expert_session(expert_folder(recording.parent_path()), reader);
        progress.at(0.5);
        write_file_atomically(report, session::report_html(reader, options), FileKind::kPage);
        progress.at(1);
        return made;
      },
      [&s, report, then = std::move(then)](std::shared_ptr<const SessionResult> made) {
        s.outcome.report = report;
        s.outcome.result = std::move(made);
        s.say(s.text("op.report_ready"));
        log::info("report written: {}", report.string());
        if (then) then();
      });
}

void make_score(OperatorState& s, BackgroundTask& work, std::shared_ptr<const Unscored> of) {
  work.make(
      [of = std::move(of)](Progress& progress) {
        progress.stage("op.scoring", 0, 0.6);
        const session::Score score = final_score(of->scene, of->tissue, of->hand);
        progress.stage("op.scoring", 0.6, 1);
        auto made = pictured_result(score, result_of(of->scene, of->tissue));
        progress.at(1);
        return made;
      },
      [&s](std::shared_ptr<const SessionResult> made) {
        log::info("scored: {:.1f} of {:.0f}", made->score.points, made->score.full);
        s.outcome.result = std::move(made);
      });
}

void show_report(OperatorState& s, BackgroundTask& work, const SessionEntry& of) {
  const fs::path report = fs::path(of.file).replace_extension(".html");
  if (of.report) return s.to_open.push_back(report.string());
  s.outcome = {};
  s.outcome.recording = of.file;
  make_report(s, work, of.file, [&s, report] {
    list_sessions(s);
    s.to_open.push_back(report.string());
  });
}

void make_curve(OperatorState& s, BackgroundTask& work, const SessionEntry& of) {
  const fs::path folder = of.file.parent_path(), page = folder / "learning_curve.html";
  make_file(s, work, "learning curve", page, true, [folder, page, language = s.language](Progress& progress) {
    progress.stage("op.making_report");
    const std::string html = session::learning_curve_html(sessions_in(folder, progress), language);
    write_file_atomically(page, html, FileKind::kPage);
    progress.at(1);
  });
}

void make_film(OperatorState& s, BackgroundTask& work, const SessionEntry& of) {
  const fs::path from = of.file, film = fs::path(from).replace_extension(".mp4");
  make_file(s, work, "film", film, true, [from, film](Progress& progress) {
    progress.stage("op.filming");
    run_self({"replay", from.string(), "--film", film.string()}, progress);
  });
}

void make_surface(OperatorState& s, BackgroundTask& work, const SessionEntry& of) {
  constexpr std::array kEndings = {".stl", ".ply", ".obj", ".glb"};
  const fs::path from = of.file,
                 mesh = fs::path(from).replace_extension(kEndings.at(static_cast<std::size_t>(s.mesh_format)));
  make_file(s, work, "surface", mesh, false, [from, mesh](Progress& progress) {
    progress.stage("op.exporting");
    surface::require_mesh_format(mesh);
    const StoredTissue stored = stored_tissue(from, [&](double fraction) { progress.at(fraction); });
    const surface::WholeMesh whole = whole_surface(stored.volume, stored.draws_own, 0.1f,
                                                   [&](double fraction) { progress.at(0.3 + 0.6 * fraction); });
    if (whole.triangles.empty()) throw Error(from.string(), "", "no surface", "tissue");
    progress.at(0.9);
    surface::write_mesh(mesh, whole, stored.volume.frame(), stored.materials);
    progress.at(1);
  });
}

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
