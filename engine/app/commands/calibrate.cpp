// typodont calibrate …: the set-up routine of a bench and its single solvers.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "calibration/calibration_files.h"
#include "engine/app/commands/commands.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/units.h"

namespace typodont {

using namespace calibration;

namespace {

/// Where a result goes: a file, standard output as JSON, or words for people.
struct Output {
  std::string file;
  bool json = false;
  void add_to(CLI::App& command) {
    command.add_option("--out", file, "write the result to this JSON file");
    command.add_flag("--json", json, "print the result as JSON");
  }
  void write(const std::string& result, const std::string& words) const {
    if (!file.empty()) write_file_atomically(file, result);
    fmt::print("{}", json ? result : words);
  }
};

std::string words(const dvec3& v) { return fmt::format("{:.3f}, {:.3f}, {:.3f}", v.x, v.y, v.z); }

void add_register(CLI::App& calibrate) {
  struct Options {
    std::string pairs, targets;
    double sigma_mm = 0;
    std::vector<double> workspace_mm;
    Output out;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = calibrate.add_subcommand("register", "rigid registration X_DH of paired points");
  command->add_option("--pairs", options->pairs, "CSV: hx_mm,hy_mm,hz_mm,dx_mm,dy_mm,dz_mm")->required();
  command->add_option("--targets", options->targets, "CSV of points in H (x_mm,y_mm,z_mm) to predict the error at");
  command->add_option("--sigma-mm", options->sigma_mm, "known noise of a touch per axis; else estimated")
      ->check(CLI::PositiveNumber);
  command->add_option("--workspace-mm", options->workspace_mm, "box in H: x0 y0 z0 x1 y1 z1; else that of the inliers")
      ->expected(6);
  options->out.add_to(*command);
  command->footer(
      "X_DH takes points of the haptic base H to the display D. Covariance: rotation vector (rad), then translation\n"
      "(mm), both in D. Indices of pairs count from 0.\n"
      "Example: typodont calibrate register --pairs touches.csv --out reg.json");
  command->callback([options] {
    const PointPairs pairs = read_pairs(options->pairs);
    const std::vector<dvec3> targets =
        options->targets.empty() ? std::vector<dvec3>{} : read_points(options->targets);
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
    options->out.write(registration_json(result, targets), text);
  });
}

void add_delay(CLI::App& calibrate) {
  struct Options {
    std::string a, b;
    double max_ms = 2000;
    Output out;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = calibrate.add_subcommand("delay", "time offset between two recordings of one motion");
  command->add_option("--a", options->a, "CSV: t_s,x_mm,y_mm,z_mm")->required();
  command->add_option("--b", options->b, "CSV: t_s,x_mm,y_mm,z_mm")->required();
  command->add_option("--max-ms", options->max_ms, "search this far both ways")
      ->check(CLI::Range(1.0, 60000.0))
      ->capture_default_str();
  options->out.add_to(*command);
  command->footer(
      "Sign: delay_ms is positive when B lags A: b(t) = a(t - delay). When the clocks run apart, delay_ms holds at the\n"
      "first common moment, and delay_at_end_ms at the last.\n"
      "Example: typodont calibrate delay --a haptic.csv --b tracker.csv --json");
  command->callback([options] {
    const Stream a = read_stream(options->a), b = read_stream(options->b);
    const DelayResult result = estimate_delay(a, b, {options->max_ms * 1e-3});
    if (result.ambiguous) log::warn("{}", result.reason);
    else if (!result.rich) log::warn("the motion was not rich enough for 0.1 ms: move faster, or longer");
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

}  // namespace

void add_calibrate(CLI::App& app) {
  CLI::App* calibrate = app.add_subcommand("calibrate", "set up a bench: what you see is where you feel it");
  add_register(*calibrate);
  add_delay(*calibrate);
  calibrate->require_subcommand(0, 1);
}

}  // namespace typodont
