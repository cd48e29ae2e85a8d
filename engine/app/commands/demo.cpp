// The command `typodont demo`: the demonstration that ./run demo starts.
#include "engine/app/demo.h"

#include <memory>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/operator/library.h"
#include "engine/app/picture/eye_size.h"
#include "engine/app/picture/hud.h"
#include "engine/contract/session_length.h"
#include "haptics/contact_method.h"

namespace typodont {

void add_demo_command(cli::Command& app) {
  auto options = std::make_shared<DemoOptions>();
  auto size = std::make_shared<std::string>();
  auto language = std::make_shared<std::string>();
  cli::Command* command =
      app.add_command("demo", "A demonstration: a scripted hand removes the caries of a CT molar, offscreen");
  command->footer("Example:\n  typodont demo --out demo");
  command->add_option("--out", options->out, "folder for the results")->show_default()->check(cli::writes_folder());
  command->add_option("--scene", options->scene, "another scene with caries (JSON)");
  command->add_option("--rig", options->rig, "another rig (JSON), or the name of one in assets/rigs");
  command->add_option("--size", *size, "WIDTHxHEIGHT of one eye's picture; where not given the rig's (full HD)");
  command->add_option("--model", options->model,
                      "contact model instead of the scene's, " + haptics::known_contact_methods());
  command->add_option("--fps", options->fps, "frames a second of the film")
      ->check(cli::range(1.0, 120.0))
      ->show_default();
  command->add_option("--seconds", options->seconds, "stop after this session time")
      ->check(cli::range(0.1, kLongestSession));
  command->add_option("--language", *language,
                      "language of the text over the picture: en, de or zh; otherwise the window's language");
  command->callback([options, size, language] {
    options->language = hud_language(user_language(*language));
    if (!size->empty()) options->eye_size = parse_size(*size);
    run_demo(*options);
  });
}

}  // namespace typodont
