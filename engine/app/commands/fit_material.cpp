// `typodont fit-material`: fits the densities of a sphere packing to a recorded force curve.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/base/error.h"
#include "engine/base/progress.h"
#include "engine/session/session_file.h"
#include "engine/session/ticks_csv.h"
#include "haptics/material_fit.h"

namespace typodont {

namespace {

struct FitMaterialOptions {
  std::string input, scene, out, plot;
  double eta = 0;
  int rounds = 60;
  bool json = false;
};

/// Reads a force curve: the columns tool_* and force_*.
std::vector<haptics::FeedSample> read_curve(const std::string& input) {
  const std::vector<ServoTick> ticks =
      input.ends_with(".h5") ? session::SessionReader(input).ticks()
                             : session::read_ticks_csv(input, {"t_s", "tool_x_mm", "tool_y_mm", "tool_z_mm",
                                                               "force_x_N", "force_y_N", "force_z_N"});
  std::vector<haptics::FeedSample> samples;
  samples.reserve(ticks.size());
  for (const ServoTick& tick : ticks) {
    samples.push_back({to_seconds(tick.t), {tick.X_WG.p, tick.X_WT.R}, glm::length(tick.f_T_W)});
  }
  return samples;
}

/// Draws one curve as SVG text, scaled so that the value ranges fill the plot.
std::string polyline(const std::vector<double>& x, const std::vector<double>& y, double x_max, double y_min,
                     double y_max, double left, double top, double width, double height, const char* color) {
  std::string points;
  for (std::size_t i = 0; i < x.size(); ++i) {
    points += fmt::format("{:.1f},{:.1f} ", left + width * x[i] / x_max,
                          top + height * (1 - (y[i] - y_min) / (y_max - y_min)));
  }
  return fmt::format(R"(<polyline fill="none" stroke="{}" stroke-width="1.5" points="{}"/>)", color, points);
}

/// Plots the fit: at the left the error over the iterations, at the right both force curves.
std::string plot(const haptics::MaterialFit& fit) {
  std::vector<double> rounds, logs, t;
  for (std::size_t i = 0; i < fit.error.size(); ++i) {
    rounds.push_back(static_cast<double>(i));
    logs.push_back(std::log10(std::max(fit.error[i], 1e-12)));
  }
  for (const double at : fit.t) t.push_back(at - fit.t.front());
  const auto [low, high] = std::minmax_element(logs.begin(), logs.end());
  const double bottom = std::floor(*low), top = std::max(std::ceil(*high), bottom + 1);
  const double most = 1.05 * std::max(*std::max_element(fit.measured.begin(), fit.measured.end()),
                                      *std::max_element(fit.simulated.begin(), fit.simulated.end()));
  const double seconds = std::max(t.back(), 1e-9), last = std::max(rounds.back(), 1.0);
  std::string svg =
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="960" height="360" font-family="sans-serif" font-size="12">)"
      R"(<rect width="960" height="360" fill="white"/>)";
  for (const double left : {70.0, 550.0}) {
    svg += fmt::format(R"(<rect x="{}" y="40" width="380" height="260" fill="none" stroke="#888"/>)", left);
  }
  for (double p = bottom; p <= top; ++p) {
    const double y = 40 + 260 * (1 - (p - bottom) / (top - bottom));
    svg += fmt::format(R"(<text x="64" y="{:.1f}" text-anchor="end">{:g}</text>)", y + 4, std::pow(10, p));
  }
  for (int k = 0; k <= 4; ++k) {
    svg += fmt::format(R"(<text x="544" y="{:.1f}" text-anchor="end">{:.3g}</text>)", 304 - 65.0 * k, most * k / 4);
    svg += fmt::format(R"(<text x="{:.1f}" y="318" text-anchor="middle">{:.3g}</text>)", 70 + 95.0 * k, last * k / 4);
    svg +=
        fmt::format(R"(<text x="{:.1f}" y="318" text-anchor="middle">{:.3g}</text>)", 550 + 95.0 * k, seconds * k / 4);
  }
  svg += R"(<text x="70" y="28">mean square error, N², over rounds of eq. 14</text>)";
  svg +=
      R"(<text x="550" y="28">force, N, over time, s: <tspan fill="#c60">measured</tspan>, <tspan fill="#06c">simulated</tspan></text>)";
  svg += polyline(rounds, logs, last, bottom, top, 70, 40, 380, 260, "#06c");
  svg += polyline(t, fit.measured, seconds, 0, most, 550, 40, 380, 260, "#c60");
  svg += polyline(t, fit.simulated, seconds, 0, most, 550, 40, 380, 260, "#06c");
  return svg + "</svg>\n";
}

void run(const FitMaterialOptions& options) {
  const Scene scene = read_scene(options.scene);
  const std::vector<haptics::FeedSample> samples = read_curve(options.input);
  Progress progress("fit-material");
  const haptics::TissueVolume tissue = load_tissue(scene);
  haptics::FitOptions fit_options;
  fit_options.eta = options.eta;
  fit_options.rounds = options.rounds;
  fit_options.progress = [&](double fraction) { progress.at(0.2 + 0.8 * fraction); };
  const haptics::MaterialFit fit =
      haptics::fit_material(tissue, servo_settings(scene, tissue, 1000), samples, fit_options, options.input);
  progress.at(1);

  nlohmann::ordered_json material = {{"spheres", fit.hardness.size()},
                                     {"seed", fit.seed},
                                     {"tissue_hash", fmt::format("{:016x}", fit.tissue_hash)},
                                     {"mean_square_error_N2", fit.error.back()}};
  nlohmann::ordered_json sphere = nlohmann::ordered_json::array(), hardness = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < fit.hardness.size(); ++i) {
    if (!fit.fitted[i]) continue;
    sphere.push_back(i);
    hardness.push_back(std::round(static_cast<double>(fit.hardness[i]) * 1e5) / 1e5);
  }
  const std::size_t fitted = sphere.size();
  material["sphere"] = std::move(sphere), material["hardness"] = std::move(hardness);
  write_file_atomically(options.out, material.dump() + "\n", FileKind::kJson);
  if (!options.plot.empty()) write_file_atomically(options.plot, plot(fit), FileKind::kDrawing);

  if (options.json) {
    const nlohmann::ordered_json json = {{"moments", fit.t.size()},
                                         {"fitted_spheres", fitted},
                                         {"mean_square_error_N2", fit.error},
                                         {"force_max_N", *std::max_element(fit.measured.begin(), fit.measured.end())},
                                         {"eta_g_sum_w2", fit.stability},
                                         {"out", options.out},
                                         {"plot", options.plot}};
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{} moments, {} spheres: mean square error from {:.4g} to {:.4g} N²\nwrote {}\n", fit.t.size(), fitted,
             fit.error.front(), fit.error.back(), options.out);
}

}  // namespace

void add_fit_material_command(cli::Command& app) {
  auto options = std::make_shared<FitMaterialOptions>();
  cli::Command* command =
      app.add_command("fit-material", "Find the densities of a packing from a recorded force curve");
  command->footer(
      "Example:\n  typodont fit-material ticks.csv --scene assets/scenes/acetabular-reaming.json --out material.json "
      "--plot fit.svg\nThen in the scene: \"model\": {\"packing\": {…, \"material\": \"material.json\"}}");
  command
      ->add_option("input", options->input, "session (.h5) or table of ticks (.csv): where the tool was, and its force")
      ->required();
  command->add_option("--scene", options->scene, "the tissue, with the model packing")->required();
  command->add_option("--out", options->out, "densities to write (.json)", cli::writes({FileKind::kJson}))->required();
  command->add_option("--plot", options->plot, "picture of the convergence to write (.svg)",
                      cli::writes({FileKind::kDrawing}));
  command->add_option("--eta", options->eta, "step size, density per newton (default: a stable one)",
                      cli::range(1e-9, 1e9));
  command->add_setting("--rounds", options->rounds, "times through the curve", cli::range(1, 100000));
  command->add_flag("--json", options->json, "print the summary as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
