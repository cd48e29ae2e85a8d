// This program once more, beside the window: what must not take the window with it when it fails.
#pragma once

#include <string>
#include <vector>

#include "engine/base/progress.h"

namespace typodont {

/// Runs `typodont ARGUMENTS` to its end and returns what it printed. Cancelled, it is ended at once. Throws Cancelled,
/// RunFailure where it cannot be started. `nice`: 19 stands back for everything else.
std::string run_self(const std::vector<std::string>& arguments, Progress& progress, int nice = 0);

/// Starts `typodont ARGUMENTS`, which goes on by itself.
void start_self(const std::vector<std::string>& arguments);

/// Opens a file or folder with what the desktop has for it. Returns at once.
void open_with_desktop(const std::string& file);

}  // namespace typodont
