// `typodont fit-damping`: fits the coupling's spring and damper to the recording of a push.
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/units.h"
#include "haptics/material_fit.h"

namespace typodont {

namespace {

constexpr std::string_view kHeader = "t_s,depth_mm,force_N";

struct Options {
  std::string curve;
  bool json = false;
};

std::vector<haptics::PushSample> read_curve(const std::string& file) {
  LineReader lines(file, InputKind::kTable);
  std::string line;
  if (!lines.next(line) || line != kHeader) throw Error(file, "line 1", line, kHeader);
  std::vector<haptics::PushSample> samples;
  while (lines.next(line)) {
    if (line.empty()) continue;
    const auto fail = [&](std::string_view expected) {
      throw Error(file, fmt::format("line {}", lines.number()), line, expected);
    };
    std::array<double, 3> cells{};
    const char *at = line.data(), *const end = at + line.size();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto result = std::from_chars(at, end, cells[i]);
      if (result.ec != std::errc() || !std::isfinite(cells[i])) fail("three numbers");
      at = result.ptr;
      if (i + 1 < cells.size() && (at == end || *at++ != ',')) fail("three numbers");
    }
    if (at != end) fail("three numbers");
    const haptics::PushSample sample{cells[0], cells[1] * kMillimetre, cells[2]};
    if (!samples.empty() && !(sample.t > samples.back().t)) fail("a later time");
    samples.push_back(sample);
  }
  return samples;
}

void run(const Options& options) {
  const haptics::DampingFit fit = haptics::fit_damping(read_curve(options.curve));
  const double stiffness = fit.stiffness / kNewtonPerMillimetre, damping = fit.damping / kNewtonPerMillimetre;
  if (options.json) {
    const nlohmann::ordered_json json = {{"stiffness_N_per_mm", stiffness},
                                         {"damping_Ns_per_mm", damping},
                                         {"rms_N", fit.rms},
                                         {"samples", fit.samples}};
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("\"coupling\": {{ \"stiffness_N_per_mm\": {:.6g}, \"damping_Ns_per_mm\": {:.6g} }}\n", stiffness,
               damping);
    fmt::print("{:.3g} N rms left of {} samples in contact\n", fit.rms, fit.samples);
  }
}

}  // namespace

void add_fit_damping_command(cli::Command& app) {
  auto options = std::make_shared<Options>();
  cli::Command* command =
      app.add_command("fit-damping", "Fit a coupling's spring and damper to the curve of a measured push");
  command->footer("Example:\n  typodont fit-damping push.csv");
  command->add_option("curve", options->curve, "table t_s,depth_mm,force_N")->required();
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
