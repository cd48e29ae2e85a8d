// `typodont case`: generates an exercise from a case family, a seed and a difficulty.
#include "engine/app/cases/case.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/base/error.h"

namespace typodont {

namespace {

struct CaseOptions {
  CaseRequest request;
  std::string out;
  bool list = false, json = false;
};

void list() {
  for (const CaseFamily& family : case_families())
    fmt::print("{}: {}; {}{}; {}\n", family.name, family.title.in(session::Language::kEnglish),
               family.teeth.empty() ? "no tooth" : "teeth ", fmt::join(family.teeth, " "),
               fmt::join(family.parameters, ", "));
}

void run(const CaseOptions& options) {
  if (options.list) {
    if (!options.request.family.empty() || !options.out.empty())
      throw Error("--list", "", "a family or --out too", "--list alone");
    return list();
  }
  if (options.request.family.empty()) throw Error("case", "", "no family", "a family of `typodont case --list`");
  if (options.out.empty()) throw Error("case", "", "no --out", "--out SCENE.json");
  const Case made = make_case(options.request, options.out);
  if (options.json) {
    nlohmann::ordered_json json = {{"family", options.request.family},
                                   {"seed", options.request.seed},
                                   {"difficulty", options.request.difficulty},
                                   {"tooth", made.tooth.type},
                                   {"parameters", made.parameters},
                                   {"expert_points", made.expert},
                                   {"careless_points", made.careless},
                                   {"out", options.out}};
    fmt::print("{}\n", json.dump(2));
    return;
  }
  if (!made.tooth.type.empty()) fmt::print("{}\n", in_words(made.tooth));
  for (const auto& [name, value] : made.parameters) fmt::print("  {} {:.2f}\n", name, value);
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
  command->add_flag("--list", options->list, "list the families, their teeth and parameters");
  command->add_flag("--json", options->json, "print the summary as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
