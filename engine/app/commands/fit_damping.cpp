// `typodont fit-damping`: fits the coupling's spring and damper to the recording of a push.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/base/csv.h"
#include "engine/base/units.h"
#include "haptics/material_fit.h"

namespace typodont {

namespace {

struct FitDampingOptions {
  std::string curve;
  bool json = false;
};

std::vector<haptics::PushSample> read_damping_curve(const std::string& file) {
  const CsvTable table = read_csv(file, {"t_s", "depth_mm", "force_N"});
  std::vector<haptics::PushSample> samples;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const haptics::PushSample sample{table.value(row, "t_s"), table.value(row, "depth_mm") * kMillimetre,
                                     table.value(row, "force_N")};
    if (!samples.empty() && !(sample.t > samples.back().t))
      table.fail(row, "t_s", fmt::format("{}", sample.t), "a later time");
    samples.push_back(sample);
  }
  return samples;
}

void run(const FitDampingOptions& options) {
  const haptics::DampingFit fit = haptics::fit_damping(read_damping_curve(options.curve));
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
  auto options = std::make_shared<FitDampingOptions>();
  cli::Command* command =
      app.add_command("fit-damping", "Fit a coupling's spring and damper to the curve of a measured push");
  command->footer("Example:\n  typodont fit-damping push.csv");
  command->add_option("curve", options->curve, "table t_s,depth_mm,force_N")->required();
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
