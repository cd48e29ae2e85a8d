#include "engine/app/operator/session_works.h"

#include <fmt/format.h>

#include <array>
#include <memory>

#include "engine/app/operator/archive.h"
#include "engine/app/operator/child.h"
#include "engine/app/operator/library.h"
#include "engine/app/review/session_report.h"
#include "engine/base/log.h"
#include "engine/session/report.h"
#include "engine/session/session_file.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

void written(OperatorState& s, const char* what, const fs::path& file) {
  s.say(fmt::format("{} {}", s.text("op.written"), file.string()));
  log::info("{} written: {}", what, file.string());
}

}  // namespace

void make_report(OperatorState& s, LongWork& work, const fs::path& recording, std::function<void()> then) {
  const fs::path report = fs::path(recording).replace_extension(".html");
  const auto score = std::make_shared<session::Score>();
  work.begin(
      [recording, report, language = s.language, score](Progress& progress) {
        progress.stage("op.making_report", 0, 0.6);
        session::repair_session(recording);
        const session::SessionReader reader(recording);
        progress.at(0.2);
        session::ReportOptions options = report_of(reader);
        options.language = language;
        if (!options.score) options.score = session::score_session(reader);
        *score = *options.score;
        progress.stage("op.making_report", 0.6, 1);
        options.earlier = earlier_sessions(recording.parent_path(), reader);
        options.expert = expert_session(expert_folder(recording.parent_path()), reader);
        progress.at(0.5);
        write_file_atomically(report, session::report_html(reader, options), FileKind::kPage);
        progress.at(1);
      },
      [&s, report, score, then = std::move(then)] {
        s.outcome.report = report;
        s.outcome.score = *score;
        s.outcome.scored = true;
        s.say(s.text("op.report_ready"));
        log::info("report written: {}", report.string());
        if (then) then();
      });
}

void make_score(OperatorState& s, LongWork& work, std::shared_ptr<const Unscored> of) {
  const auto score = std::make_shared<session::Score>();
  work.begin(
      [of = std::move(of), score](Progress& progress) {
        progress.stage("op.scoring", 0, 1);
        *score = final_score(of->scene, of->tissue, of->hand);
        progress.at(1);
      },
      [&s, score] {
        s.outcome.score = *score;
        s.outcome.scored = true;
        log::info("scored: {:.1f} of {:.0f}", score->points, score->full);
      });
}

void show_report(OperatorState& s, LongWork& work, const SessionEntry& of) {
  const fs::path report = fs::path(of.file).replace_extension(".html");
  if (of.report) return open_with_desktop(report.string());
  s.outcome = {};
  s.outcome.recording = of.file;
  make_report(s, work, of.file, [&s, report] {
    s.sessions = find_sessions();
    open_with_desktop(report.string());
  });
}

void make_curve(OperatorState& s, LongWork& work, const SessionEntry& of) {
  const fs::path folder = of.file.parent_path(), page = folder / "learning_curve.html";
  const int language = static_cast<int>(s.language);
  work.begin([=](Progress& progress) { write_learning_curve(folder, page, language, progress); },
             [&s, page] {
               written(s, "learning curve", page);
               open_with_desktop(page.string());
             });
}

void make_film(OperatorState& s, LongWork& work, const SessionEntry& of) {
  const fs::path from = of.file, film = fs::path(from).replace_extension(".mp4");
  work.begin(
      [=](Progress& progress) {
        progress.stage("op.filming");
        run_self({"replay", from.string(), "--film", film.string()}, progress);
      },
      [&s, film] {
        written(s, "film", film);
        open_with_desktop(film.string());
      });
}

void make_surface(OperatorState& s, LongWork& work, const SessionEntry& of) {
  constexpr std::array kEndings = {".stl", ".ply", ".obj"};
  const fs::path from = of.file,
                 mesh = fs::path(from).replace_extension(kEndings.at(static_cast<std::size_t>(s.mesh_format)));
  work.begin([=](Progress& progress) { export_surface(from, mesh, progress); },
             [&s, mesh] { written(s, "surface", mesh); });
}

}  // namespace typodont
