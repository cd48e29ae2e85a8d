// `typodont report`: writes a session as one HTML page.
#include "engine/session/report.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/app/cases/case.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/commands/values.h"
#include "engine/app/operator/library.h"
#include "engine/app/review/session_report.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "engine/session/place.h"
#include "engine/session/score.h"
#include "engine/session/signature.h"

namespace typodont {

namespace {

struct ReportArguments {
  std::string session, out, language, expert, earlier, key;
  std::vector<std::string> pictures;
  bool json = false, verify = false;
};

/// Writes the learning curve of all sessions in a folder.
void run_folder(const ReportArguments& options, session::Language language) {
  using namespace session;
  Progress progress("sessions");
  const std::vector<SessionSummary> sessions = sessions_in(options.session, progress);
  write_file_atomically(options.out, learning_curve_html(sessions, language), FileKind::kPage);
  if (options.json) {
    nlohmann::json list = nlohmann::json::array();
    for (const SessionSummary& s : sessions) {
      list.push_back({{"file", s.file},
                      {"date", s.date},
                      {"scene", s.scene},
                      {"truncated", s.truncated},
                      {"points", s.score.points},
                      {"full", s.score.full},
                      {"passed", s.score.counts() && s.score.passed()}});
    }
    const nlohmann::json result = {{"report", options.out}, {"sessions", list}};
    fmt::print("{}\n", result.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    fmt::print("{}: {} sessions\n", options.out, sessions.size());
  }
}

/// Adds the measures of an implant exercise to the JSON object `to`: phases and drilled hole.
void add_implant(const session::ImplantMeasures& m, const session::Score& score, nlohmann::json& to) {
  to["score"] = score.points;
  to["phases"] = nlohmann::json::array();
  for (const session::ImplantPhaseMeasures& phase : m.phases) {
    nlohmann::json notes = nlohmann::json::object();
    for (std::size_t n = 1; n < phase.noted.size(); ++n) {
      if (phase.noted[n] > 0) notes[std::string(name_of(static_cast<session::ImplantNote>(n)))] = phase.noted[n];
    }
    to["phases"].push_back({{"name", phase.name[0]},
                            {"done", phase.done},
                            {"skipped", phase.skipped},
                            {"began_s", phase.began >= 0 ? nlohmann::json(phase.began) : nlohmann::json()},
                            {"ended_s", phase.ended >= 0 ? nlohmann::json(phase.ended) : nlohmann::json()},
                            {"force_max_N", phase.force_max},
                            {"over_force_s", phase.over_force},
                            {"depth_mm", phase.depth * 1e3},
                            {"temperature_C", phase.hottest},
                            {"notes_s", notes}});
  }
  // Converts a value to JSON; an unknown value becomes null.
  const auto known = [](double value, double unit) {
    return value >= 0 && value < 1 ? nlohmann::json(value * unit) : nlohmann::json();
  };
  const session::ImplantBedMeasures& bed = m.bed;
  if (bed.found) {
    to["bed"] = {{"axis_error_deg", bed.axis_error / kDegree},
                 {"depth_mm", bed.depth * 1e3},
                 {"diameter_mm", known(bed.diameter, 1e3)},
                 {"ovality_mm", known(bed.ovality, 1e3)},
                 {"entry_error_mm", bed.entry_error * 1e3},
                 {"apex_error_mm", bed.apex_error * 1e3},
                 {"canal_mm", known(bed.canal_distance, 1e3)},
                 {"neighbour_mm", known(bed.neighbour_distance, 1e3)},
                 {"perforated_percent", known(bed.perforated / 100, 1e4)}};
  } else {
    to["bed"] = nullptr;
  }
  to["placed"] = m.placed;
  to["insertion_torque_Ncm"] = m.insertion_torque * 100;
  to["bone_contact_percent"] = known(m.bone_contact / 100, 1e4);
  to["over_force_s"] = m.over_force;
  to["temperature_C"] = m.hottest;
}

nlohmann::json mm_of(const dvec3& p_W) {
  return vec(p_W, kMillimetre);
}
nlohmann::json json_of(const session::PlaceName& place) {
  return {{"part", place.part}, {"side", place.side}, {"third", place.third}};
}

nlohmann::json json_of(const session::Defect& defect, const session::SessionReader& reader,
                       const session::ReportOptions& report, const std::optional<session::ToothSides>& tooth) {
  nlohmann::json json = {
      {"name", defect.item},        {"amount", defect.amount}, {"unit", session::unit_of(defect.item)},
      {"at_mm", mm_of(defect.p_W)}, {"left", defect.left},     {"strokes", nlohmann::json::array()}};
  if (tooth && report.preparation && defect.on_tooth)
    json["at"] = json_of(place_name(*report.preparation, *tooth, defect.p_W));
  const auto& tools = reader.header().tools;
  for (const session::DefectStroke& stroke : defect.strokes) {
    json["strokes"].push_back({{"from_s", stroke.from},
                               {"to_s", stroke.to},
                               {"worst_s", stroke.at.t},
                               {"amount", stroke.amount},
                               {"tool", stroke.tool < tools.size() ? tools[stroke.tool] : ""},
                               {"head_mm", mm_of(stroke.at.X_WG.p)},
                               {"axis", mm_of(stroke.at.X_WG.R * dvec3(0, 0, 1e-3))},
                               {"force_N", stroke.at.force}});
  }
  return json;
}

void run(const ReportArguments& options) {
  using namespace session;
  std::error_code code;
  if (std::filesystem::is_directory(options.session, code)) return run_folder(options, user_language(options.language));
  const OpenedSession session(options.session);
  if (!options.key.empty()) require_signature(session, options.key);
  const SessionReader reader(session);
  require_output(options.out, FileKind::kPage);
  const Language language = user_language(options.language);
  std::vector<SessionPicture> pictures;
  for (const std::string& argument : options.pictures) {
    const auto equals = argument.find('=');
    if (equals == std::string::npos || equals == 0) throw Error("--picture", "", argument, "NAME=FILE.png");
    pictures.push_back(read_picture(argument.substr(equals + 1), argument.substr(0, equals)));
  }
  std::optional<Progress> progress("report");
  progress->at(0.05);
  ReportOptions report = report_of(reader);
  progress->at(0.7);
  report.language = language;
  report.remarks = read_remarks(options.session);
  report.more_pictures = std::move(pictures);
  using State = Verification::State;
  if (options.verify && report.verification.state == State::kNotChecked) report.verification = verify(reader);
  if (report.verification.state == State::kOtherLaw) log::warn("{}: {}", options.session, report.verification.what);
  if (!report.score) report.score = score_session(reader);
  if (!options.expert.empty()) report.expert = summary_of(SessionReader(options.expert));
  if (!options.earlier.empty()) {
    if (!std::filesystem::is_directory(options.earlier, code)) {
      throw Error("--earlier", "", options.earlier, "a folder of sessions");
    }
    report.earlier = earlier_sessions(options.earlier, reader);
  }
  progress->at(0.8);
  const std::string page = report_html(reader, report);
  progress->at(0.95);
  write_file_atomically(options.out, page, FileKind::kPage);
  progress->at(1);
  progress.reset();  // ends the progress line before other output

  if (options.json) {
    nlohmann::json items = nlohmann::json::array();
    std::optional<Json> scene;
    if (const std::string& text = reader.header().scene_json; !text.empty()) scene = Json::parse(text, options.session);
    const auto tooth = scene ? tooth_sides(*scene) : std::nullopt;
    for (const ScoreItem& item : report.score->items) {
      items.push_back({{"name", item.name},
                       {"value", item.value},  // JSON null if nothing could be measured
                       {"unit", item.unit},
                       {"target", item.target},
                       {"tolerance", item.tolerance},
                       {"weight", item.weight},
                       {"points", item.points},
                       {"full", item.full},
                       {"critical_error", item.critical},
                       {"source", item.source}});
      if (item.place_W) {
        items.back()["worst_at_mm"] = mm_of(*item.place_W);
        if (tooth && report.preparation)
          items.back()["worst_at"] = json_of(place_name(*report.preparation, *tooth, *item.place_W));
      }
    }
    nlohmann::json result = {
        {"report", options.out},
        {"signature", options.key.empty() ? nlohmann::json() : nlohmann::json("valid")},
        {"ticks", reader.tick_count()},
        {"truncated", reader.truncated()},
        {"points", report.score->points},
        {"full", report.score->full},
        {"completion", report.score->completion},
        {"date", reader.header().date},
        {"case", nullptr},
        {"pass_mark", report.score->pass.points},
        {"pass_source", report.score->pass.source},
        {"passed", report.score->counts() && report.score->passed()},
        {"not_measured", report.not_measured.empty() ? nlohmann::json() : nlohmann::json(report.not_measured)},
        {"items", items},
        {"defects", nlohmann::json::array()}};
    if (const auto made = scene ? case_in(*scene) : std::nullopt) result["case"] = json_of(*made);
    for (const Defect& defect : report.defects) result["defects"].push_back(json_of(defect, reader, report, tooth));
    if (report.input && report.input->implant) add_implant(*report.input->implant, *report.score, result);
    if (report.input && report.input->explore)
      for (const session::SiteReading& site : report.input->explore->sites)
        result["sites"].push_back(
            {{"depth_mm", site.depth * 1e3},
             {"reading_mm", site.reading < 0 ? nlohmann::json() : nlohmann::json(site.reading * 1e3)},
             {"force_N", site.force}});
    if (const auto& hardness = report.input ? report.input->removed_hardness : std::nullopt)
      if (const auto means = by_tissue(*hardness, 1); !means.empty()) result["removed_hardness"] = means;
    fmt::print("{}\n", result.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    const Score& score = *report.score;
    fmt::print("{}: {:.1f} of {:.0f} points{}, {} ticks{}\n", options.out, printed_points(score.points), score.full,
               !score.counts()  ? ""
               : score.passed() ? ", passed"
                                : ", not passed",
               reader.tick_count(), reader.truncated() ? ", cut off before its end" : "");
  }
  if (options.verify && report.verification.state != State::kIdentical)
    throw RunFailure("the replay differs: " + report.verification.what);
}

}  // namespace

void add_report_command(cli::Command& app) {
  cli::Command* command = app.add_command("report", "Make a report (one HTML page) from a recorded session");
  const auto options = std::make_shared<ReportArguments>();
  command
      ->add_option("SESSION", options->session,
                   "A session recorded by run, demo or servo (.h5), or a folder with them: the learning curve")
      ->required();
  command->add_option("--out", options->out, "The page to write (.html)", cli::writes({FileKind::kPage}))->required();
  command->add_option("--language", options->language, "en, de or zh; otherwise the window's language");
  command->add_option(
      "--picture", options->pictures,
      "NAME=FILE.png: a picture beside those in the session; names before, during_1, after set the order");
  command->add_option("--expert", options->expert, "An expert's session of the same scene, to compare with (.h5)");
  command->add_option("--earlier", options->earlier, "A folder with the trainee's earlier sessions, to compare with");
  command->add_flag(
      "--verify", options->verify,
      "Replay the recorded hand first; the page states whether the recording agrees with it, exit 1 if not");
  command->add_option("--key", options->key, "No page and exit 1 if it is not signed with the key in this file");
  command->add_flag("--json", options->json, "Print the score as JSON");
  command->footer("Example: typodont report out/session.h5 --out report.html --language de");
  command->callback([options, command] {
    std::error_code code;
    command->refuse_without({"--expert", "--earlier", "--picture", "--key"},
                            !std::filesystem::is_directory(options->session, code), "one session");
    run(*options);
  });
}

}  // namespace typodont
