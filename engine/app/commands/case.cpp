// `typodont case`: generates an exercise from a case family, a seed and a difficulty.
#include "engine/app/cases/case.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/base/csv.h"
#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

struct CaseOptions {
  CaseRequest request;
  std::string out, hands;
  bool list = false, json = false;
};

void list() {
  for (const CaseFamily& family : case_families())
    fmt::print("{}: {}; {}{}; {}\n", family.name, family.title.in(session::Language::kEnglish),
               family.teeth.empty() ? "no tooth" : "teeth ", fmt::join(family.teeth, " "),
               fmt::join(family.parameters, ", "));
}

/// Reads the simulated hands, one per row. Missing columns are 0.
std::vector<HandErrors> read_hands(const std::string& file, std::uint64_t seed) {
  const CsvTable table =
      read_csv(file, {"x_mm", "y_mm", "z_mm"}, {"tilt_x_deg", "tilt_y_deg", "spread_mm", "force_N", "force_max_N"});
  std::vector<HandErrors> hands(table.rows.size());
  for (std::size_t k = 0; k < hands.size(); ++k) {
    const auto cell = [&](const char* name, double low, double high) {
      const double value = table.column(name) < 0 ? 0 : table.value(k, name);
      if (!(value >= low && value <= high))
        table.fail(k, name, fmt::format("{:g}", value), fmt::format("{:g} to {:g}", low, high));
      return value;
    };
    hands[k] = {.shift = kMillimetre * dvec3(cell("x_mm", -5, 5), cell("y_mm", -5, 5), cell("z_mm", -5, 5)),
                .tilt = kDegree * glm::dvec2(cell("tilt_x_deg", -45, 45), cell("tilt_y_deg", -45, 45)),
                .spread = kMillimetre * cell("spread_mm", 0, 1),
                .seed = (seed << 32) + k + 1,
                .force_mean = cell("force_N", 0, 100),
                .force_max = cell("force_max_N", 0, 100)};
  }
  return hands;
}

void run(const CaseOptions& options) {
  if (options.list) {
    if (!options.request.family.empty() || !options.out.empty())
      throw Error("--list", "", "a family or --out too", "--list alone");
    return list();
  }
  if (options.request.family.empty()) throw Error("case", "", "no family", "a family of `typodont case --list`");
  if (options.out.empty()) throw Error("case", "", "no --out", "--out SCENE.json");
  std::vector<HandErrors> hands;
  if (!options.hands.empty()) hands = read_hands(options.hands, options.request.seed);
  const Case made = make_case(options.request, options.out, hands);
  if (options.json) {
    nlohmann::ordered_json json = {{"family", options.request.family},
                                   {"seed", options.request.seed},
                                   {"difficulty", options.request.difficulty},
                                   {"tooth", made.tooth.type},
                                   {"parameters", made.parameters},
                                   {"expert_points", made.expert},
                                   {"careless_points", made.careless},
                                   {"out", options.out}};
    for (const session::Score& hand : made.hands) {
      nlohmann::ordered_json items = nlohmann::ordered_json::object();
      for (const session::ScoreItem& item : hand.items) items[item.name] = item.value;
      json["hands"].push_back({{"points", hand.points}, {"passed", hand.passed()}, {"items", std::move(items)}});
    }
    fmt::print("{}\n", json.dump(2));
    return;
  }
  if (!made.tooth.type.empty()) fmt::print("{}\n", in_words(made.tooth));
  for (const auto& [name, value] : made.parameters) fmt::print("  {} {:.2f}\n", name, value);
  for (std::size_t k = 0; k < made.hands.size(); ++k)
    fmt::print("hand {}: {:.1f} points\n", k + 1, made.hands[k].points);
  fmt::print("exact plan {:.1f} points, careless hand {:.1f} points\nwrote {}\n", made.expert, made.careless,
             options.out);
}

}  // namespace

void add_case_command(cli::Command& app) {
  auto options = std::make_shared<CaseOptions>();
  cli::Command* command = app.add_command("case", "Make an exercise of a family from a seed and a difficulty");
  command->footer("Example:\n  typodont case class-1 --seed 7 --difficulty 0.4 --out case.json");
  command->add_option("family", options->request.family, "family of exercises, one of --list");
  command->add_setting("--seed", options->request.seed, "number of the case; equal seeds give equal files",
                       cli::range(0.0, 4294967295.0));
  command->add_setting("--difficulty", options->request.difficulty, "0, easy, to 1, hard", cli::range(0.0, 1.0));
  command->add_option("--tooth", options->request.tooth,
                      "tooth of the family instead of the seed's: U upper or L lower, and 1 to 7 from the midline");
  command->add_option("--scan", options->request.scan,
                      "scene with a scanned tooth, of the type --tooth, in place of a parametric one");
  command->add_option("--out", options->out, "scene to write; its volume is beside it, with the ending .vdb",
                      cli::writes({FileKind::kJson}));
  command->add_option("--hands", options->hands, "table of the errors of simulated hands, which are scored too",
                      cli::existing_file());
  command->add_flag("--list", options->list, "list the families, their teeth and parameters");
  command->add_flag("--json", options->json, "print the summary as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
