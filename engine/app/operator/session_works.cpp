#include "engine/app/operator/session_works.h"

#include <fmt/format.h>

#include <array>
#include <memory>

#include "engine/app/operator/archive.h"
#include "engine/app/operator/child.h"
#include "engine/app/operator/library.h"
#include "engine/app/operator/result_picture.h"
#include "engine/app/operator/session_scores.h"
#include "engine/app/review/session_report.h"
#include "engine/base/log.h"
#include "engine/session/report.h"
#include "engine/session/session_file.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

/// Data that the result page shows about a finished session.
struct Made {
  session::Score score;
  render::Picture picture;
  bool compared = false;  // true: the picture shows the difference from the target shape
};
void show(OperatorState& s, Made& made) {
  s.outcome.score = made.score;
  s.outcome.picture = std::move(made.picture);
  s.outcome.compared = made.compared;
  s.outcome.scored = true;
}

void written(OperatorState& s, const char* what, const fs::path& file) {
  s.say(fmt::format("{} {}", s.text("op.written"), file.string()));
  log::info("{} written: {}", what, file.string());
}

}  // namespace

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
        Made made{*options.score, picture_of_result(options), options.ideal.has_value()};
        cache_score(recording, known(reader, made.score));
        progress.stage("op.making_report", 0.6, 1);
        options.earlier = earlier_sessions(recording.parent_path(), reader);
        options.expert = expert_session(expert_folder(recording.parent_path()), reader);
        progress.at(0.5);
        write_file_atomically(report, session::report_html(reader, options), FileKind::kPage);
        progress.at(1);
        return made;
      },
      [&s, report, then = std::move(then)](Made made) {
        s.outcome.report = report;
        show(s, made);
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
        const session::ReportOptions result = result_of(of->scene, of->tissue);
        Made made{score, picture_of_result(result), result.ideal.has_value()};
        progress.at(1);
        return made;
      },
      [&s](Made made) {
        show(s, made);
        log::info("scored: {:.1f} of {:.0f}", made.score.points, made.score.full);
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
  const int language = static_cast<int>(s.language);
  work.begin([=](Progress& progress) { write_learning_curve(folder, page, language, progress); },
             [&s, page] {
               written(s, "learning curve", page);
               s.to_open.push_back(page.string());
             });
}

void make_film(OperatorState& s, BackgroundTask& work, const SessionEntry& of) {
  const fs::path from = of.file, film = fs::path(from).replace_extension(".mp4");
  work.begin(
      [=](Progress& progress) {
        progress.stage("op.filming");
        run_self({"replay", from.string(), "--film", film.string()}, progress);
      },
      [&s, film] {
        written(s, "film", film);
        s.to_open.push_back(film.string());
      });
}

void make_surface(OperatorState& s, BackgroundTask& work, const SessionEntry& of) {
  constexpr std::array kEndings = {".stl", ".ply", ".obj", ".glb"};
  const fs::path from = of.file,
                 mesh = fs::path(from).replace_extension(kEndings.at(static_cast<std::size_t>(s.mesh_format)));
  work.begin([=](Progress& progress) { export_surface(from, mesh, progress); },
             [&s, mesh] { written(s, "surface", mesh); });
}

}  // namespace typodont
