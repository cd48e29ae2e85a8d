// This program once more, beside the window: what must not take the window with it when it fails.
#pragma once

#include <string>
#include <vector>

#include "engine/base/progress.h"

namespace typodont {

/// Runs `typodont ARGUMENTS` to its end and returns what it printed; how far it says it is goes to `progress`.
/// Cancelled, it is asked to end, and made to. `nice`: 19 stands back for everything else. Throws Cancelled; RunFailure
/// with its own last words where it fails without an answer.
std::string run_self(const std::vector<std::string>& arguments, Progress& progress, int nice = 0);

/// Starts `typodont ARGUMENTS`, which goes on by itself.
void start_self(const std::vector<std::string>& arguments);

/// Opens a file or folder with what the desktop has for it. Returns at once.
void open_with_desktop(const std::string& file);

}  // namespace typodont
