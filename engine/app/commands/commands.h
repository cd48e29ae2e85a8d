// The program's commands: one file each, named as the user types it.
#pragma once

namespace CLI {
class App;
}

namespace typodont {

// Each adds its subcommand to `app`; the work runs in the subcommand's callback. It throws Error (exit 2) or
// RunFailure (exit 1), prints results on standard output and messages on standard error.
void add_calibrate(CLI::App& app);

}  // namespace typodont
