// `typodont calibrate`: the guided set-up of a bench, and a subcommand for each solver.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>

#include "calibration/bench_simulator.h"
#include "calibration/calibration_files.h"
#include "calibration/camera_solver.h"
#include "calibration/guided_capture.h"
#include "calibration/joint_solver.h"
#include "calibration/report_page.h"
#include "calibration/rig_file.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/guide/delay_capture.h"
#include "engine/app/guide/guide_stage.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/units.h"

namespace typodont {

using namespace calibration;

namespace {

/// Where a calibration result is written: to a file, as JSON on standard output, or as text.
struct Output {
  std::string file;
  bool json = false;
  void add_to(cli::Command& command) {
    command.add_option("--out", file, "write the result to this JSON file", cli::writes({FileKind::kJson}));
    command.add_flag("--json", json, "print the result as JSON");
  }
  void write(const std::string& result, const std::string& words) const {
    if (!file.empty()) write_file_atomically(file, result, FileKind::kJson);
    fmt::print("{}", json ? result : words);
  }
};

std::string words(const dvec3& v) {
  return fmt::format("{:.3f}, {:.3f}, {:.3f}", v.x, v.y, v.z);
}

void add_register(cli::Command& calibrate) {
  struct Options {
    std::string pairs, targets, rig;
    double sigma_mm = 0;
    std::vector<double> workspace_mm;
    Output out;
  };
  auto options = std::make_shared<Options>();
  cli::Command* command = calibrate.add_command("register", "rigid registration X_DH of paired points");
  command->add_option("--pairs", options->pairs, "CSV: hx_mm,hy_mm,hz_mm,dx_mm,dy_mm,dz_mm (or _m)")->required();
  command->add_option("--targets", options->targets,
                      "CSV of points in H (x_mm,y_mm,z_mm, or _m) to predict the error at");
  command->add_option("--sigma-mm", options->sigma_mm, "known noise of a touch per axis; else estimated",
                      cli::more_than_zero());
  command->add_option("--workspace-mm", options->workspace_mm, "box in H: x0 y0 z0 x1 y1 z1; else that of the inliers")
      ->expected(6);
  command->add_option("--rig", options->rig, "store X_DH as X_WH in this rig file, unless the result is unreliable");
  options->out.add_to(*command);
  command->footer(
      "X_DH takes points of the haptic base H to the display D. Covariance: rotation vector (rad), then translation\n"
      "(mm), both in D. Indices of pairs count from 0.\n"
      "Example: typodont calibrate register --pairs touches.csv --out reg.json");
  command->callback([options] {
    const PointPairs pairs = read_pairs(options->pairs);
    auto rig = options->rig.empty() ? std::nullopt : std::optional(RigFile::load(options->rig));
    const std::vector<dvec3> targets = options->targets.empty() ? std::vector<dvec3>{} : read_points(options->targets);
    RegistrationOptions settings;
    settings.known_sigma = options->sigma_mm * kMillimetre;
    if (const auto& w = options->workspace_mm; w.size() == 6) {
      settings.workspace_H = {dvec3(w[0], w[1], w[2]) * kMillimetre, dvec3(w[3], w[4], w[5]) * kMillimetre};
    }
    const RegistrationResult result = register_points(pairs.H, pairs.D, settings);
    const Pose& X = result.X_DH;
    std::string text = fmt::format(
        "X_DH        translation {} mm, rotation {:.6f}, {:.6f}, {:.6f}, {:.6f} (wxyz)\n"
        "noise       {:.4f} mm per axis, {:.4f} mm rms residual\n"
        "prediction  {:.4f} mm rms target error over the workspace\n"
        "pairs       {} used, {} set aside\n",
        words(X.p * 1e3), X.R.w, X.R.x, X.R.y, X.R.z, result.sigma * 1e3, result.fre_rms * 1e3,
        result.predicted_tre_rms * 1e3, result.inliers.size(), result.outliers.size());
    for (std::size_t i = 0; i < targets.size(); ++i) {
      text += fmt::format("target {:<4} {:.4f} mm\n", i, predicted_tre(result, targets[i]) * 1e3);
    }
    if (result.degeneracy.defect != Defect::kNone) log::warn("do not use this: {}", result.degeneracy.reason);
    if (!result.rivals.empty()) {
      log::warn("ambiguous: {} pairs agree on one motion and {} on another", result.inliers.size(),
                result.rivals.front().pairs.size());
    }
    if (rig && result.trusted()) {
      BenchState bench = rig->bench();
      bench.rig.X_WH = result.X_DH;
      bench.registration = result;
      rig->set(bench);
      rig->save();
    }
    options->out.write(registration_json(result, targets), text);
  });
}

/// Differences between the commands `hand-eye` and `robot-world`.
struct PoseCommand {
  const char* name;
  const char* about;
  const char *X, *Z;  // names of the poses that are computed, for example "X_SM"
  const char *X_what, *Z_what;
  const char* b_columns;  // help text about the pose in the columns bx_mm … bqz
  const char* footer;
  bool camera_on_arm;
};
constexpr PoseCommand kPoseCommands[] = {
    {"hand-eye", "the pose of a camera on the stylus, from poses of stylus and target (A X = X B)", "X_SK", "X_HM",
     "the camera K on the stylus S", "the target M in the base H", "of the target in the camera (X_KM)",
     "Solves X_HS X_SK X_KM = X_HM for X_SK and X_HM. With --motions every row holds a motion of the stylus and the "
     "one\n"
     "of the camera: A X_SK = X_SK B.\nTurn the stylus by 30° and more, about two axes; 15 poses or more.\n"
     "Example: typodont calibrate hand-eye --poses poses.csv --out hand_eye.json",
     true},
    {"robot-world", "the poses of a tracker and of its marker on the stylus (A X = Z B)", "X_SM", "X_HK",
     "the marker M on the stylus S", "the tracker K in the base H", "of the marker in the tracker (X_KM)",
     "Solves X_HS X_SM = X_HK X_KM for X_SM and X_HK.\n"
     "Turn the stylus by 30° and more, about two axes; 15 poses or more.\n"
     "Example: typodont calibrate robot-world --poses poses.csv --out robot_world.json",
     false}};

void add_pose_command(cli::Command& calibrate, const PoseCommand& kind) {
  struct Options {
    std::string poses;
    bool motions = false;
    Output out;
  };
  auto options = std::make_shared<Options>();
  cli::Command* command = calibrate.add_command(kind.name, kind.about);
  command
      ->add_option(
          "--poses", options->poses,
          fmt::format("CSV: ax_mm,ay_mm,az_mm,aqw,aqx,aqy,aqz of the stylus in the base (X_HS), the same with b "
                      "{}; _m for metres",
                      kind.b_columns))
      ->required();
  if (kind.camera_on_arm) {
    command->add_flag("--motions", options->motions, "the rows hold motions of stylus and camera instead of poses");
  }
  options->out.add_to(*command);
  command->footer(kind.footer);
  command->callback([options, &kind] {
    PosePairs pairs = read_pose_pairs(options->poses);
    HandEyeOptions settings;
    settings.motions = options->motions;
    if (kind.camera_on_arm && !options->motions) {
      for (Pose& pose : pairs.B) pose = inverse(pose);
    }
    if (const std::size_t least = options->motions ? 2 : 3; pairs.A.size() < least) {
      throw Error(options->poses, "", fmt::format("{} rows", pairs.A.size()), fmt::format("at least {}", least));
    }
    const HandEyeResult result = solve_hand_eye(pairs.A, pairs.B, settings);
    if (!result.not_determined.empty()) throw RunFailure(fmt::format("{}: {}", kind.name, result.not_determined));
    const auto line = [](const char* name, const char* what, const Pose& X, const std::array<double, 36>& covariance) {
      const auto sigma = [&](std::size_t first) {
        double variance = 0;
        for (std::size_t i = first; i < first + 3; ++i) variance = std::max(variance, covariance[7 * i]);
        return std::sqrt(variance);
      };
      return fmt::format(
          "{}   {}: translation {} mm ± {:.4f}, rotation {:.6f}, {:.6f}, {:.6f}, {:.6f} (wxyz) ± {:.4f}°\n", name, what,
          words(X.p * 1e3), sigma(3) * 1e3, X.R.w, X.R.x, X.R.y, X.R.z, sigma(0) / kDegree);
    };
    std::string text = line(kind.X, kind.X_what, result.X, result.X_covariance);
    if (!options->motions) text += line(kind.Z, kind.Z_what, result.Z, result.Z_covariance);
    text += fmt::format(
        "noise  {:.4f} mm and {:.4f}° per axis; {} rows used, {} set aside; turns of {:.1f}° and {:.1f}° rms\n",
        result.translation_sigma * 1e3, result.rotation_sigma / kDegree, result.inliers.size(), result.outliers.size(),
        result.main_turn / kDegree, result.second_turn / kDegree);
    options->out.write(hand_eye_json(result, kind.X, options->motions ? nullptr : kind.Z), text);
  });
}

void add_delay(cli::Command& calibrate) {
  struct Options {
    std::string a, b, rig;
    DelayCaptureOptions live;
    double max_ms = 2000;
    Output out;
  };
  auto options = std::make_shared<Options>();
  cli::Command* command = calibrate.add_command("delay", "time offset between two recordings of one motion");
  command->add_option("--a", options->a, "CSV: t_s,x_mm,y_mm,z_mm");
  command->add_option("--b", options->b, "CSV: t_s,x_mm,y_mm,z_mm");
  command->add_option("--rig", options->rig,
                      "rig file: recordings are read from or written beside it, and the delay is stored in it");
  command->add_option("--hand", options->live.hand, "record A from this hand (typodont devices) …");
  command->add_option("--with", options->live.with, "… and B at the same time from this one, or from opentrack:PORT");
  command->add_setting("--pedal", options->live.pedal, "\"none\", or the pedal's path or serial");
  command->add_setting("--seconds", options->live.seconds, "longest recording; it ends earlier once 0.1 ms is reached",
                       cli::range(4.0, 600.0));
  command->add_setting("--max-ms", options->max_ms, "search range in both directions", cli::range(1.0, 60000.0));
  options->out.add_to(*command);
  command->footer(
      "Sign: delay_ms is positive when B lags A: b(t) = a(t - delay). When the clocks run apart, delay_ms holds at "
      "the\n"
      "first common moment, and delay_at_end_ms at the last.\n"
      "Example: typodont calibrate delay --a haptic.csv --b tracker.csv --json\n"
      "Example: typodont calibrate delay --rig bench.json --hand haply: --with opentrack:4242");
  command->callback([options] {
    auto rig = options->rig.empty() ? std::nullopt : std::optional(RigFile::load(options->rig));
    Captures captures;
    if (const bool live = !options->live.hand.empty();
        live != !options->live.with.empty() || (live && !options->a.empty())) {
      throw Error("calibrate delay: found a part of it, expected --hand with --with, or --a with --b, or --rig");
    } else if (live) {
      const DelayCapture taken = capture_delay(options->live);
      captures.delay_a = taken.a, captures.delay_b = taken.b;
      if (rig) write_captures(rig->captures_folder(), captures);
    } else if (!options->a.empty() && !options->b.empty()) {
      captures.delay_a = read_stream(options->a), captures.delay_b = read_stream(options->b);
    } else if (rig && options->a.empty() && options->b.empty()) {
      const std::filesystem::path folder = rig->captures_folder();
      captures.delay_a = read_stream(folder / "delay_a.csv"), captures.delay_b = read_stream(folder / "delay_b.csv");
    } else {
      throw Error("calibrate delay: found one recording, expected --a with --b, or --hand with --with, or --rig");
    }
    const DelayResult result = estimate_delay(captures.delay_a, captures.delay_b, {options->max_ms * 1e-3});
    if (rig && !result.ambiguous) {
      BenchState bench = rig->bench();
      bench.delay = result;
      rig->set(bench);
      rig->save();
    }
    if (result.ambiguous)
      log::warn("{}", result.reason);
    else if (!result.rich)
      log::warn("the motion was not enough for 0.1 ms: move faster or longer");
    std::string text = fmt::format("delay   {:.4f} ms ± {:.4f} ms (positive: B lags A){}\n", result.delay * 1e3,
                                   result.sigma * 1e3, result.ambiguous ? ", ambiguous" : "");
    if (result.skew != 0) {
      text += fmt::format("skew    {:.2f} ± {:.2f} ppm; {:.4f} ms at the end\n", result.skew * 1e6,
                          result.skew_sigma * 1e6, result.delay_at_end * 1e3);
    }
    text += fmt::format("noise   {:.4f} mm per axis over {} samples; lost {} and {}, frozen {} and {}, rejected {}\n",
                        result.noise * 1e3, result.samples, result.lost_a, result.lost_b, result.frozen_a,
                        result.frozen_b, result.rejected);
    options->out.write(delay_json(result), text);
  });
}

std::string summary(const BenchState& bench) {
  std::string text;
  if (const auto& r = bench.arm_result) {
    text += fmt::format("arm       {:.3f} mm rms before, {:.3f} after; {} captures, {} set aside\n",
                        r->before_rms * 1e3, r->after_rms * 1e3, r->residuals.size(), r->rejected.size());
    text += fmt::format("          not observable: {}\n", fmt::join(r->not_observable, "; "));
    if (!r->misfit.empty()) text += fmt::format("          rejected: {}\n", r->misfit);
  }
  if (const auto& r = bench.panel_result) {
    text += r->not_determined.empty() ? fmt::format("panel     {:.2f} × {:.2f} mm, {:.3f} mm rms, {} set aside\n",
                                                    r->width * 1e3, r->height * 1e3, r->rms * 1e3, r->rejected.size())
                                      : fmt::format("panel     not determined: {}\n", r->not_determined);
  }
  if (const auto& r = bench.mirror_result) {
    text += r->not_determined.empty() ? fmt::format("mirror    tilt ± {:.4f}°, {:.3f} mm rms, {} set aside\n",
                                                    r->tilt_sigma / kDegree, r->rms * 1e3, r->rejected.size())
                                      : fmt::format("mirror    not determined: {}\n", r->not_determined);
  }
  if (const auto& r = bench.eyes_result) {
    text += r->not_determined.empty()
                ? fmt::format("eyes      {:.2f} ± {:.2f} mm apart, {:.3f} mm rms, {} set aside\n", r->eyes.ipd * 1e3,
                              r->ipd_sigma * 1e3, r->rms * 1e3, r->rejected.size())
                : fmt::format("eyes      not determined: {}\n", r->not_determined);
    if (const auto& offset = r->user_offset) {
      text += fmt::format(
          "          this user feels points ({}) ± ({}) mm from where they are seen; {} touches, {} set aside\n",
          words(offset->W * 1e3), words(offset->sigma * 1e3), offset->touches, offset->rejected);
    }
  }
  if (const auto& r = bench.joint) {
    text += fmt::format(
        "together  eyes {:.2f} ± {:.2f} mm apart; this user feels points ({}) mm from where they are seen\n",
        r->eyes.ipd * 1e3, r->ipd_sigma * 1e3, words(r->user_offset_W * 1e3));
    for (const JointResult::Term& term : r->terms)
      text += fmt::format("          {}: {}\n", term.name, size_in_words(term));
  }
  if (const auto& r = bench.registration) {
    text += fmt::format("register  {:.3f} mm per axis, {:.3f} mm predicted error, {} pairs, {} set aside{}\n",
                        r->sigma * 1e3, r->predicted_tre_rms * 1e3, r->inliers.size(), r->outliers.size(),
                        r->trusted() ? "" : ", not to be trusted");
  }
  if (const auto& r = bench.delay) {
    text += fmt::format("delay     {:.3f} ± {:.3f} ms{}\n", r->delay * 1e3, r->sigma * 1e3,
                        r->ambiguous ? ", ambiguous" : "");
  }
  if (const auto& r = bench.verification) text += fmt::format("verify    {}\n", r->verdict);
  return text;
}

/// Command-line options of the guided capture.
struct HandOptions : GuideOptions {
  double plate_pitch_mm = 40, still_mm = 0.3;
  bool no_window = false;

  void add_to(cli::Command& command) {
    command.add_option("--hand", hand,
                       "take touches from this hand: an address as typodont devices lists them, or script:HAND.csv");
    command.add_setting("--pedal", pedal, "\"auto\", \"none\", or the pedal's path or serial");
    command.add_setting("--still-mm", still_mm, "a touch is refused if the tip moved farther than this within 100 ms",
                        cli::range(0.001, 10.0));
    command.add_flag("--fast", fast, "a script: hand runs as fast as it can");
    command.add_flag("--no-window", no_window, "show no prompts on the screen");
    command.add_option("--monitor", monitor, "show the prompts full screen on this monitor, counted from 0",
                       cli::from_zero());
    command.add_option("--picture", picture,
                       "write what the panel should show to this PNG or PGM file before each touch",
                       cli::writes({FileKind::kPicture, FileKind::kGreyPicture}));
    command.add_option("--audio", audio, "play a cue after each touch: portaudio:[DEVICE] or wav:FILE");
    command.add_setting("--plate-pitch-mm", plate_pitch_mm, "between the points of the arm's 5 by 5 plate",
                        cli::more_than_zero());
  }
  const GuideOptions& complete() {
    still.radius = still_mm * kMillimetre;
    window = !no_window;
    return *this;
  }
};

/// Options of a calibration step that computes its result from captures and updates the rig file.
struct StepOptions {
  std::string rig, captures, report, map, arm_serial, tracker_serial;
  bool user_offset = false;
  double tip_radius_mm = 0, tolerance_mm = 0.5, worst_mm = 1.0;
  Output out;
};

void add_rig_step(cli::Command& calibrate, const char* step, const char* what, const char* files) {
  auto options = std::make_shared<StepOptions>();
  cli::Command* command = calibrate.add_command(step, what);
  const std::string_view name = step;
  command->add_option("--rig", options->rig, "rig file to read and to update")->required();
  command->add_option("--captures", options->captures, "folder of the raw captures; else RIG.captures");
  if (name == "screen") {
    command->add_option("--tip-radius-mm", options->tip_radius_mm, "of the ball at the stylus' end",
                        cli::range(0.0, 20.0));
  }
  if (name == "eyes") {
    command->add_flag(
        "--user-offset", options->user_offset,
        "also this user's systematic offset between seeing and feeling, from the touches of register and verify");
  }
  if (name == "verify") {
    command->add_option("--map", options->map, "write the map of the co-location error to this SVG picture",
                        cli::writes({FileKind::kDrawing}));
    command->add_setting("--tolerance-mm", options->tolerance_mm, "rms that passes", cli::more_than_zero());
    command->add_setting("--worst-mm", options->worst_mm, "worst that passes", cli::more_than_zero());
  }
  command->add_option("--report", options->report, "write a page with plots to this HTML file",
                      cli::writes({FileKind::kPage}));
  command->add_option("--arm-serial", options->arm_serial, "serial number to keep in the rig file");
  command->add_option("--tracker-serial", options->tracker_serial, "serial number to keep in the rig file");
  options->out.add_to(*command);
  command->footer(
      fmt::format("Reads {} of the captures.\nExample: typodont calibrate {} --rig bench.json", files, step));
  command->callback([options, step = std::string(step)] {
    RigFile rig = RigFile::load(options->rig);
    BenchState bench = rig.bench();
    bench.tolerance = {options->tolerance_mm * kMillimetre, options->worst_mm * kMillimetre};
    const std::filesystem::path folder =
        options->captures.empty() ? rig.captures_folder() : std::filesystem::path(options->captures);
    const Captures captures = read_captures(folder);
    const auto need = [&](bool any, const char* file) {
      if (!any)
        throw Error((folder / file).string(), "", "no captures", "those of this step; see typodont calibrate guide");
    };
    if (step == "arm") need(!captures.arm.empty(), "arm.csv"), solve_arm_step(bench, captures);
    if (step == "screen")
      need(!captures.marks.empty(), "marks.csv"),
          solve_screen_step(bench, captures, options->tip_radius_mm * kMillimetre);
    if (step == "eyes")
      need(!captures.eyes.empty(), "eyes.csv"), solve_eyes_step(bench, captures, options->user_offset);
    if (step == "verify") need(!captures.verification.empty(), "verify.csv"), solve_verify_step(bench, captures);
    if (step == "solve") solve_all(bench, captures);
    rig.set(bench);
    if (!options->arm_serial.empty()) rig.set_device("arm", options->arm_serial);
    if (!options->tracker_serial.empty()) rig.set_device("tracker", options->tracker_serial);
    if (!options->report.empty())
      write_file_atomically(options->report, report_page(bench, "Calibration of " + options->rig), FileKind::kPage);
    if (!options->map.empty())
      write_file_atomically(options->map, error_map_svg(*bench.verification), FileKind::kDrawing);
    rig.save();
    options->out.write(bench_json(bench), summary(bench));
    if (bench.verification && !bench.verification->pass) throw RunFailure("verify: " + bench.verification->verdict);
  });
}

void add_drift(cli::Command& calibrate) {
  struct Options {
    std::string rig, touches;
    double tolerance_mm = 0.3, sigma_mm = 0.2;
    HandOptions guide;
    Output out;
  };
  auto options = std::make_shared<Options>();
  cli::Command* command = calibrate.add_command("drift", "check three marks at the start of a session for drift");
  command->add_option("--rig", options->rig, "rig file; drift.csv of its captures holds the marks")->required();
  command->add_option("--touches", options->touches,
                      "CSV of the same marks touched now: x_mm,y_mm,z_mm; else they are asked for");
  command->add_setting("--tolerance-mm", options->tolerance_mm, "that a mark may have moved", cli::more_than_zero());
  command->add_setting("--sigma-mm", options->sigma_mm, "noise of a touch per axis", cli::more_than_zero());
  options->guide.add_to(*command);
  options->out.add_to(*command);
  command->footer(
      "The marks are first touched with typodont calibrate guide drift.\n"
      "Example: typodont calibrate drift --rig bench.json --hand haply:\n"
      "Example: typodont calibrate drift --rig bench.json --touches today.csv");
  command->callback([options] {
    const RigFile rig = RigFile::load(options->rig);
    const BenchState bench = rig.bench();
    const std::filesystem::path file = rig.captures_folder() / "drift.csv";
    const auto points = [&](const std::vector<Touch>& touches) {
      std::vector<dvec3> list;
      for (const Touch& touch : touches) list.push_back(touch.at(bench.arm));
      return list;
    };
    const std::vector<dvec3> then = points(read_touches(file));
    const auto touched_now = [&] {
      if (!options->touches.empty()) return read_touches(options->touches);
      // The check before a session has its own folder, so that it does not use old captures.
      const std::filesystem::path folder = rig.captures_folder() / "today";
      std::error_code code;
      std::filesystem::remove(folder / "drift.csv", code);
      GuidedCapture guide(bench, folder);
      guide.begin(Step::kDrift);
      options->guide.rig = options->rig;
      if (run_guide(guide, options->guide.complete()) != GuideEnd::kSolve)
        throw RunFailure("drift: stopped before the marks were touched");
      return guide.captures().drift_marks;
    };
    const std::vector<dvec3> now = points(touched_now());
    if (now.size() != then.size()) {
      throw Error(options->touches.empty() ? "drift" : options->touches, "", fmt::format("{} touches", now.size()),
                  fmt::format("the {} marks of {}", then.size(), file.string()));
    }
    const dvec3 middle = inverse(bench.rig.X_WH) * (0.5 * (bench.workspace_D.low + bench.workspace_D.high));
    const DriftResult result =
        check_drift(then, now, options->sigma_mm * kMillimetre, middle, options->tolerance_mm * kMillimetre);
    options->out.write(
        fmt::format("{{\n  \"drifted\": {},\n  \"shift_mm\": {},\n  \"turn_deg\": {},\n  \"worst_mm\": {}\n}}\n",
                    result.drifted, result.shift * 1e3, result.turn / kDegree, result.worst * 1e3),
        result.verdict + "\n");
    if (result.drifted) throw RunFailure(result.verdict);
  });
}

void add_status(cli::Command& calibrate) {
  auto file = std::make_shared<std::string>();
  cli::Command* command = calibrate.add_command("status", "list the completed steps, and those to repeat");
  command->add_option("--rig", *file, "rig file")->required();
  command->footer("Example: typodont calibrate status --rig bench.json");
  command->callback([file] {
    const RigFile rig = RigFile::load(*file);
    GuidedCapture guide(rig.bench(), rig.captures_folder());
    std::string newest;
    for (const Step step : kSteps) {
      guide.begin(step);
      const std::string date = rig.step_date(name(step));
      const char* advice = date.empty() ? "to do" : date < newest ? "again: an earlier step is newer" : "done, skip it";
      fmt::print("{:<9} {:>4} touches  {:<21} {}\n", name(step), guide.taken(), date.empty() ? "never solved" : date,
                 advice);
      newest = std::max(newest, date);
    }
    const std::string date = rig.step_date("delay");
    fmt::print("{:<9} {:>4} streams  {:<21} {}\n", "delay",
               std::filesystem::exists(rig.captures_folder() / "delay_b.csv") ? 2 : 0,
               date.empty() ? "never solved" : date,
               date.empty() ? "to do: calibrate delay --hand … --with …" : "done, skip it");
  });
}

/// Runs one step of the calibration: capture, compute, store in the rig file. False: the user stopped.
bool guide_step(RigFile& rig, Step step, HandOptions& options) {
  GuidedCapture guide(rig.bench(), rig.captures_folder(), options.plate_pitch_mm * kMillimetre);
  guide.begin(step);
  std::string device;
  const GuideEnd end = run_guide(guide, options.complete(), &device);
  if (end != GuideEnd::kSolve) return end == GuideEnd::kSkip;
  guide.solve();
  rig.set(guide.bench());
  if (!device.empty()) rig.set_device("arm", device);
  if (step == Step::kDrift) rig.mark_done(name(step));
  rig.save();
  fmt::print("{}", summary(guide.bench()));
  if (const auto& checked = guide.bench().verification; step == Step::kVerify && checked && !checked->pass)
    throw RunFailure("verify: " + checked->verdict);
  return true;
}

void add_guide(cli::Command& calibrate) {
  struct Options : HandOptions {
    std::string step;
  };
  auto options = std::make_shared<Options>();
  cli::Command* command = calibrate.add_command(
      "guide", "guided capture of one step, or of all open steps; can be interrupted and continued");
  command->add_option(
      "step", options->step,
      "arm, screen, mirror, eyes, register, verify or drift; without it all steps that are not done, in order");
  command->add_option("--rig", options->rig, "rig file")->required();
  options->add_to(*command);
  command->footer(
      "With --hand a touch is the tip's mean place, in the base frame, over the 100 ms before the pedal goes down or "
      "Enter\n"
      "is typed; the hand feels no force. On a desktop the prompts are shown in a window (--monitor N: on the panel), "
      "which\n"
      "takes Enter, U, D, S and Q; a touch that does not fit the others is ringed where it lies. The step arm takes "
      "the\n"
      "joint angles of hands that tell them.\n"
      "Standard input: x y z in mm, or six joint angles in rad, is a touch; undo or u; done or d (solve and stop); "
      "skip or\n"
      "s (go on with the next step); quit or q (stop; captures are kept).\n"
      "Example: typodont calibrate guide register --rig bench.json --hand haply: --monitor 1 --audio portaudio:\n"
      "Example: typodont calibrate guide --rig bench.json --hand woodenhaptics:\n"
      "Example: device-reader | typodont calibrate guide register --rig bench.json");
  command->callback([options] {
    RigFile rig = RigFile::load(options->rig);
    if (!options->step.empty()) {
      const auto step = step_named(options->step);
      if (!step)
        throw Error("calibrate guide: found step \"" + options->step +
                    "\", expected arm, screen, mirror, eyes, register, verify or drift");
      guide_step(rig, *step, *options);
      return;
    }
    std::string newest;
    for (const Step step : kSteps) {
      const std::string date = rig.step_date(name(step));
      const bool done = !date.empty() && date >= newest;
      fmt::print("== {}{}\n", name(step), done ? ": done, skipped" : "");
      if (!done && !guide_step(rig, step, *options)) return;
      newest = std::max(newest, rig.step_date(name(step)));
    }
  });
}

void add_camera(cli::Command& calibrate) {
  struct Options {
    std::string rig, sightings, picture, out_picture;
    std::vector<int> size{1920, 1080};
    int columns = 9, rows = 6;
    bool mirrored = false;
    double touch_sigma_mm = 0.2, pixel_sigma = 0.1;
    Output out;
  };
  auto options = std::make_shared<Options>();
  const auto board_options = [options](cli::Command* command) {
    command->add_setting("--columns", options->columns, "inner corners across", cli::range(3, 60));
    command->add_setting("--rows", options->rows, "inner corners down; columns + rows must be odd", cli::range(3, 60));
  };

  cli::Command* board = calibrate.add_command("board", "draw the chessboard that the panel shows to a camera");
  board_options(board);
  board->add_option("--size", options->size, "pixels of the panel", cli::range(64, 16384))->expected(2);
  board
      ->add_option("--out", options->out_picture, "PNG or PGM file",
                   cli::writes({FileKind::kPicture, FileKind::kGreyPicture}))
      ->required();
  board->footer("Example: typodont calibrate board --size 1920 1080 --out board.pgm");
  board->callback([options] {
    const BoardPicture drawn = draw_board(options->columns, options->rows, options->size[0], options->size[1]);
    write_picture(options->out_picture, {drawn.width, drawn.height, drawn.grey});
  });

#ifdef TYPODONT_CAMERA
  cli::Command* detect = calibrate.add_command("detect", "find that chessboard in a camera's picture");
  board_options(detect);
  detect->add_option("picture", options->picture, "PNG, JPEG or PGM")->required();
  detect->add_option("--size", options->size, "pixels of the panel", cli::range(64, 16384))->expected(2);
  detect->add_flag("--mirrored", options->mirrored, "the board is seen in the mirror");
  detect->footer("Prints u,v,px,py, one corner a line.\nExample: typodont calibrate detect view1.png --mirrored");
  detect->callback([options] {
    const auto corners = draw_board(options->columns, options->rows, options->size[0], options->size[1]).corners;
    const auto pixels = find_board(options->picture, options->columns, options->rows, options->mirrored);
    if (pixels.empty()) throw RunFailure(options->picture + ": the board is not seen whole");
    fmt::print("u,v,px,py\n");
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      fmt::print("{},{},{},{}\n", corners[i].u, corners[i].v, pixels[i].x, pixels[i].y);
    }
  });
#endif

  cli::Command* camera = calibrate.add_command(
      "camera", "panel and mirror from corners seen by a camera and points touched with the stylus");
  camera->add_option("--sightings", options->sightings, "CSV: picture,on,px,py and u,v or x_mm,y_mm,z_mm (in W)")
      ->required();
  camera->add_option("--rig", options->rig, "rig file to read and to update")->required();
  camera->add_option("--size", options->size, "pixels of the camera's pictures", cli::range(64, 16384))->expected(2);
  camera->add_setting("--touch-sigma-mm", options->touch_sigma_mm, "noise of a touch per axis", cli::more_than_zero());
  camera->add_setting("--pixel-sigma", options->pixel_sigma, "noise of a corner per axis", cli::more_than_zero());
  options->out.add_to(*camera);
  camera->footer(
      "on: 0 a touched point, 1 the panel, 2 the panel in the mirror.\nExample: typodont calibrate camera --sightings "
      "corners.csv --rig bench.json");
  camera->callback([options] {
    RigFile rig = RigFile::load(options->rig);
    BenchState bench = rig.bench();
    const CameraResult result =
        solve_camera(read_sightings(options->sightings), options->size[0], options->size[1], bench.rig.panel,
                     {options->touch_sigma_mm * kMillimetre, options->pixel_sigma});
    if (!result.not_determined.empty()) throw RunFailure("camera: " + result.not_determined);
    bench.rig.panel = result.panel;
    if (result.mirror) {
      bench.rig.mirror = result.mirror;
      if (glm::dot(bench.rig.mirror->normal, bench.rig.eyes.center) < bench.rig.mirror->offset) {
        bench.rig.mirror = MirrorPlane{-result.mirror->normal, -result.mirror->offset};
      }
    }
    rig.set(bench);
    rig.save();
    options->out.write(
        camera_json(result),
        fmt::format("camera  focal length {:.2f} ± {:.2f} pixels, {:.3f} pixels rms, {} corners set aside\n"
                    "panel   {:.2f} ± {:.3f} by {:.2f} ± {:.3f} mm, tilt ± {:.4f}°\n",
                    result.camera.fx, result.camera_sigma.fx, result.rms_px, result.outliers, result.width * 1e3,
                    result.width_sigma * 1e3, result.height * 1e3, result.height_sigma * 1e3,
                    result.tilt_sigma / kDegree) +
            (result.mirror ? fmt::format("mirror  tilt ± {:.4f}°, offset ± {:.3f} mm\n",
                                         result.mirror_tilt_sigma / kDegree, result.mirror_offset_sigma * 1e3)
                           : ""));
  });
}

void simulate(const std::string& folder, const SimulationOptions& simulation, bool json) {
  const SimulatedRoutine run = simulate_routine(simulation);
  if (!folder.empty()) {
    make_folder(folder);
    RigFile rig = RigFile::create(std::filesystem::path(folder) / "rig.json");
    write_captures(rig.captures_folder(), run.captures);
    rig.set(run.bench);
    rig.mark_done(name(Step::kDrift));
    rig.set_device("arm", "simulated");
    write_file_atomically(std::filesystem::path(folder) / "report.html",
                          report_page(run.bench, "Calibration of the simulated bench"), FileKind::kPage);
    write_file_atomically(std::filesystem::path(folder) / "error_map.svg", error_map_svg(*run.bench.verification),
                          FileKind::kDrawing);
    rig.save();
  }
  const auto mm = [](double metres) { return metres * 1e3; };
  if (json) {
    std::string steps = bench_json(run.bench);
    steps.pop_back();
    fmt::print(
        "{{\n\"colocation_mm\": {{\"before\": {{\"rms\": {}, \"worst\": {}}}, \"after\": {{\"rms\": {}, \"mean\": {}, "
        "\"worst\": {}}}}},\n"
        "\"touch_noise_mm\": {},\n\"steps\": {}\n}}\n",
        mm(run.before.rms), mm(run.before.worst), mm(run.after.rms), mm(run.after.mean), mm(run.after.worst),
        mm(simulation.touch_noise), steps);
    return;
  }
  fmt::print(
      "{}co-location over the 80 mm cube: {:.3f} mm rms, {:.3f} mm worst as drawn; {:.4f} mm rms, {:.4f} mm worst "
      "now\n",
      summary(run.bench), mm(run.before.rms), mm(run.before.worst), mm(run.after.rms), mm(run.after.worst));
}

}  // namespace

void add_calibrate_command(cli::Command& app) {
  struct Options {
    bool simulate = false;
    std::string out;
    bool json = false;
    double noise_mm = 0.2, outliers = 0.02;
    bool soft = false;
    std::uint64_t seed = 1;
  };
  auto options = std::make_shared<Options>();
  cli::Command* calibrate =
      app.add_command("calibrate", "Calibrate a bench, so that objects are felt where they are seen");
  calibrate->add_flag("--simulate", options->simulate,
                      "run the whole routine against a simulated bench, e.g. --simulate --seed 7 --out bench");
  calibrate->add_option("--out", options->out, "with --simulate: folder for the rig, the captures and the report");
  calibrate->add_flag("--json", options->json, "with --simulate: print the result as JSON");
  calibrate->add_setting("--noise-mm", options->noise_mm, "with --simulate: noise of a touch per axis",
                         cli::range(0.0, 5.0));
  calibrate->add_setting("--outliers", options->outliers, "with --simulate: fraction of touches that slip",
                         cli::range(0.0, 0.4));
  calibrate->add_flag(
      "--soft", options->soft,
      "with --simulate: a bent panel, a sagging mirror and arm, and a tip that slips between the steps");
  calibrate->add_setting("--seed", options->seed, "with --simulate: seed of the bench");
  calibrate->footer(
      "Example: typodont calibrate --simulate --out bench\nExample: typodont calibrate guide screen --rig "
      "bench/rig.json --hand haply:");
  add_rig_step(*calibrate, "arm", "the arm's geometry, from the tip in sockets and on a plate", "arm.csv");
  add_rig_step(*calibrate, "screen", "panel and mirror, from touches of the stylus", "marks.csv and mirror.csv");
  add_rig_step(*calibrate, "eyes", "eye centre and distance, from alignments through the mirror", "eyes.csv");
  add_register(*calibrate);
  for (const PoseCommand& kind : kPoseCommands) add_pose_command(*calibrate, kind);
  add_delay(*calibrate);
  add_rig_step(*calibrate, "verify", "check the calibration with new points", "verify.csv");
  add_rig_step(*calibrate, "solve", "solve every step again from all captures", "all files");
  add_drift(*calibrate);
  add_guide(*calibrate);
  add_status(*calibrate);
  add_camera(*calibrate);
  calibrate->expect_commands(0, 1);
  calibrate->callback([calibrate, options] {
    calibrate->refuse_without({"--out", "--json", "--noise-mm", "--outliers", "--soft", "--seed"}, options->simulate,
                              "--simulate");
    if (calibrate->named_command()) {
      if (options->simulate) throw Error("calibrate: found --simulate with a step, expected one of them");
      return;
    }
    if (!options->simulate)
      throw Error("calibrate: found no step, expected one of those in typodont calibrate --help, or --simulate");
    SimulationOptions simulation;
    simulation.seed = options->seed;
    simulation.touch_noise = options->noise_mm * kMillimetre;
    simulation.slipped = options->outliers;
    simulation.soft = options->soft ? 1 : 0;
    simulate(options->out, simulation, options->json);
  });
}

}  // namespace typodont
