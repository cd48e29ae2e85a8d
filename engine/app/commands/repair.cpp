// `typodont repair`: recovers recordings after a crash or power loss.
#include <fmt/format.h>

#include <memory>
#include <string>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/session/session_file.h"

namespace typodont {

void add_repair_command(cli::Command& app) {
  const auto session = std::make_shared<std::string>();
  cli::Command* command =
      app.add_command("repair", "Recover a recording that was cut off by a crash or a power failure");
  command->footer("Example: typodont repair session.h5");
  command->add_option("session", *session, "unsigned recording (.h5); its journal SESSION.h5.journal lies beside it")
      ->required();
  command->callback([session] {
    fmt::print("{}: {}\n", *session,
               session::repair_session(*session) ? "repaired as far as it goes"
                                                 : "nothing to repair: it is intact or being recorded");
  });
}

}  // namespace typodont
