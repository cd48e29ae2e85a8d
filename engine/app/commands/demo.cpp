// typodont demo: what ./run demo runs.
#include "engine/app/demo.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "engine/app/commands/commands.h"
#include "engine/app/commands/option_checks.h"
#include "engine/contract/session_length.h"

namespace typodont {

void add_demo_command(CLI::App& app) {
  auto options = std::make_shared<DemoOptions>();
  CLI::App* command =
      app.add_subcommand("demo", "The showcase: a scripted hand prepares a cavity in a CT molar, offscreen");
  command->footer("Example:\n  typodont demo --out demo");
  command->add_option("--out", options->out, "folder for what it makes")->capture_default_str();
  command->add_option("--scene", options->scene, "another scene with caries (JSON)");
  command->add_option("--rig", options->rig, "another rig (JSON), or the name of one in assets/rigs");
  command->add_option("--fps", options->fps, "frames a second of the film")
      ->check(number_in(1.0, 120.0))
      ->capture_default_str();
  command->add_option("--seconds", options->seconds, "stop after so much session time")
      ->check(number_in(0.1, kLongestSession));
  command->callback([options] { run_demo(*options); });
}

}  // namespace typodont
