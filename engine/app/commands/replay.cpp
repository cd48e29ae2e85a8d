// `typodont replay`: repeats a recorded session. It checks that the result is bit-identical, shows or films the
// session, or applies the recorded motion of the hand to another scene.
#include "engine/app/recording/replay.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/commands/values.h"
#include "engine/app/operator/library.h"
#include "engine/app/picture/hud.h"
#include "engine/app/review/playback.h"
#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/log.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "engine/session/session_file.h"
#include "engine/session/signature.h"

namespace typodont {

namespace {

struct ReplayOptions {
  std::string session, with, out, eye, key, language;
  double ipd = 0;
  PlaybackOptions playback;
  bool check = false, json = false, show = false;
};

ReplayResult replay_recorded(const session::SessionReader& session) {
  Progress progress("replay");
  return replay_session(session, [&](double done) { progress.at(done); });
}

/// For a session that is only shown, without computing its forces again: if it was recorded with another force law,
/// warns in one sentence how the current law differs.
void warn_of_other_law(const session::SessionReader& session) {
  if (has_other_law(session)) log::warn("{}: {}", session.file().string(), replay_recorded(session).what_differs);
}

nlohmann::ordered_json json_of(const RerunResult& r) {
  return {{"ticks", r.ticks},
          {"seconds", r.seconds},
          {"cuts", r.cuts},
          {"force_N",
           {{"off_rms", r.force_off_rms},
            {"off_max", r.force_off_max},
            {"max", r.force_max},
            {"max_before", r.force_max_before}}},
          {"tool_mm", {{"off_rms", r.tool_off_rms * 1e3}, {"off_max", r.tool_off_max * 1e3}}},
          {"removed_mm3", {{"now", r.removed / kCubicMillimetre}, {"before", r.removed_before / kCubicMillimetre}}}};
}

nlohmann::ordered_json json_of(const ReplayResult& result, const ReplayOptions& options) {
  nlohmann::ordered_json json = {{"identical", result.identical},
                                 {"same_force_law", !result.with_todays_law},
                                 {"seconds", result.seconds},
                                 {"ticks", result.ticks},
                                 {"truncated", result.truncated}};
  if (result.with_todays_law) {
    json["with_todays_law"] = json_of(*result.with_todays_law);
  } else {
    json["field_hash"] = result.field_hash;
    json["force_hash"] = result.force_hash;
    json["faults"] = result.ticks_with_faults;
  }
  if (!result.identical) json["difference"] = result.what_differs;
  if (!options.key.empty()) json["signature"] = "valid";
  return json;
}

void print(const ReplayResult& result, const ReplayOptions& options) {
  fmt::print("{}{}: {} ticks, {:.3f} s{}\n", options.session,
             options.with.empty() ? "" : ", replayed with its own settings, without those of --with", result.ticks,
             result.seconds, result.truncated ? ", cut off" : "");
  if (!result.with_todays_law) fmt::print("forces {}, tissue {}\n", result.force_hash, result.field_hash);
  fmt::print("{}{}\n", options.with.empty() ? "" : "without --with: ",
             result.identical ? "identical to the recording" : "differs from the recording: " + result.what_differs);
}

/// Changes some keys of the recorded scene (option --with), and applies the recorded motion of the hand to this changed
/// scene. Compares the result with the recording.
RerunResult rerun(const session::SessionReader& session, const ReplayOptions& options) {
  std::string text = options.with, where = "--with";
  if (!text.starts_with("{")) {
    where = options.with;
    text = read_input(options.with, InputKind::kJson);
  }
  if (has_other_law(session))
    log::warn("{}: made with another force law, so the differences are not those of --with alone", options.session);
  const Scene scene = scene_with(session, text, where);
  Progress progress("same hand");
  return rerun_session(session, scene, options.out, [&](double done) { progress.at(done); });
}

void print(const RerunResult& r, const ReplayOptions& options) {
  fmt::print("{}, the same hand with the changed settings of --with, compared with the recording:\n", options.session);
  fmt::print("{} ticks, {:.3f} s, {} cuts\n", r.ticks, r.seconds, r.cuts);
  fmt::print("force: {:.4f} N rms and {:.4f} N at most from the recording's; at most {:.3f} N, before {:.3f} N\n",
             r.force_off_rms, r.force_off_max, r.force_max, r.force_max_before);
  fmt::print("tool: {:.4f} mm rms and {:.4f} mm at most from where it was\n", r.tool_off_rms * 1e3,
             r.tool_off_max * 1e3);
  fmt::print("removed: {:.4f} mm³, before {:.4f} mm³\n", r.removed / kCubicMillimetre,
             r.removed_before / kCubicMillimetre);
  if (!options.out.empty()) fmt::print("wrote {}\n", options.out);
}

/// Runs the comparisons that the options request: with the recorded scene, and with the changes of --with. Reports what
/// was compared. Throws RunFailure if --check finds a difference.
void compare(const session::SessionReader& session, const ReplayOptions& options) {
  const bool changed = !options.with.empty(), checks = options.check || !changed;
  RerunResult other;
  ReplayResult same;
  if (changed) other = rerun(session, options);
  if (checks) same = replay_recorded(session);
  if (options.json) {
    nlohmann::ordered_json json = changed ? json_of(other) : json_of(same, options);
    if (changed) json["out"] = options.out;
    if (changed && checks) json["replay_without_with"] = json_of(same, options);
    fmt::print("{}\n", changed ? json.dump(2) : json.dump());
  } else {
    if (changed) print(other, options);
    if (checks) print(same, options);
  }
  if (options.check && !same.identical)
    throw RunFailure(fmt::format("the replay{} differs: {}", changed ? " without --with" : "", same.what_differs));
}

void run(ReplayOptions options) {
  const session::OpenedSession session = std::filesystem::path(options.session);
  if (!options.key.empty()) session::require_signature(session, options.key);
  PlaybackOptions& playback = options.playback;
  if (!options.eye.empty()) {
    const std::vector<double> mm = numbers(options.eye, "--eye-mm", 3, 3, "X,Y,Z between the eyes, in the workbench");
    playback.eye_W = dvec3(mm[0], mm[1], mm[2]) * kMillimetre;
  }
  if (options.ipd > 0) playback.ipd = options.ipd * kMillimetre;
  if (playback.speed == 0) throw Error("", "--speed", "0", "how many times as fast; negative: backwards");
  if (!options.out.empty() && options.with.empty())
    throw Error("", "--out", options.out, "--with, whose session it is");
  if (!options.out.empty()) require_output(options.out, FileKind::kSession);
  if (!playback.film.empty()) require_output(playback.film, FileKind::kFilm);
  const bool film = !playback.film.empty();
  if (film && options.show) throw Error("", "--show", "and --film", "one of them");
  {
    const session::SessionReader reader(session);
    if (!options.with.empty() || options.check || (!film && !options.show))
      compare(reader, options);
    else
      warn_of_other_law(reader);
  }
  if (options.show) show_session(session, playback);
  if (film) {
    PlaybackResult result;
    {
      Progress progress("film");
      result = film_session(session, playback, progress);
    }
    if (!result.message.empty()) log::warn("{}", result.message);
    if (options.json) {
      const nlohmann::ordered_json json = {
          {"film", playback.film.string()}, {"frames", result.frames}, {"seconds", result.seconds}};
      fmt::print("{}\n", json.dump());
    } else {
      fmt::print("wrote {}: {} frames, {:.2f} s\n", playback.film.string(), result.frames, result.seconds);
    }
  }
}

}  // namespace

void add_replay_command(cli::Command& app) {
  auto options = std::make_shared<ReplayOptions>();
  PlaybackOptions& p = options->playback;
  cli::Command* command =
      app.add_command("replay", "Replay a recorded session bit for bit, watch it, or make a film of it");
  command->footer(
      "In the window: space pauses, arrows left and right seek 5 s, up and down change the speed, R plays backwards, L "
      "loops,\n"
      "[ and ] set the beginning and end of a loop, Backspace clears them, Home and End, V another view, Esc ends.\n"
      "Example:\n  typodont replay demo/session.h5 --check --json\n"
      "  typodont replay student.h5 --beside expert.h5 --show\n"
      "  typodont replay student.h5 --beside expert.h5 --from 20 --to 40 --speed 0.5 --film both.mp4\n"
      "  typodont replay student.h5 --with '{\"force_filter\": \"slew\"}' --out slew.h5");
  command->add_option("session", options->session, "recorded session (.h5)")->required();
  command->add_flag("--check", options->check,
                    "exit 1 if the replay differs from the recording; --with does not change this replay");
  command->add_option("--key", options->key, "exit 1 if the session is not signed with the key in this file");
  command->add_flag("--show", options->show, "watch it in a window");
  command->add_option("--film", p.film, "make a film of it (.mp4)", cli::writes({FileKind::kFilm}));
  command->add_option("--beside", p.beside,
                      "another session, shown to the right: an expert's, or the same hand in another scene");
  command->add_option(
      "--rig", p.rig,
      "rig file (JSON), or the name of one in assets/rigs; without it the window, or closeup for a film");
  command->add_option("--eye-mm", options->eye, "X,Y,Z: another viewpoint, the position of the head in the workbench");
  command->add_option("--ipd-mm", options->ipd, "distance between the eyes", cli::range(0.0, 100.0));
  command->add_option("--magnify", p.magnify, "magnify the scene by this factor", cli::range(0.1, 100.0));
  command->add_option("--from", p.from, "start time in the recording, s");
  command->add_option("--to", p.to, "where to end");
  command->add_option("--speed", p.speed, "how many times as fast; negative: backwards", cli::range(-64.0, 64.0));
  command->add_option("--loop", p.loops, "number of repetitions in a film; a window repeats unless 0",
                      cli::range(0, 1000));
  command->add_setting("--fps", p.fps, "pictures a second of a film", cli::range(1.0, 240.0));
  command->add_setting("--view", p.view, "natural, or a view for teaching",
                       cli::one_of({"look", "section", "xray", "difference", "temperature"}));
  command->add_option("--monitor", p.monitor, "show it full screen on this monitor, 0 is the first", cli::from_zero());
  command->add_option("--with", options->with,
                      "replay the hand with other settings: a JSON file or object with the changed keys of the scene");
  command->add_option("--out", options->out, "the session that --with makes (.h5)", cli::writes({FileKind::kSession}));
  command->add_option("--language", options->language,
                      "language of the text over the picture: en, de or zh; otherwise the window's language");
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options, command] {
    const bool film = !options->playback.film.empty();
    command->refuse_without({"--beside", "--rig", "--eye-mm", "--ipd-mm", "--magnify", "--from", "--to", "--speed",
                             "--loop", "--view", "--language"},
                            options->show || film, "--show or --film");
    command->refuse_without({"--monitor"}, options->show, "--show");
    command->refuse_without({"--fps"}, film, "--film");
    if (options->show || film) options->playback.language = hud_language(user_language(options->language));
    run(*options);
  });
}

}  // namespace typodont
