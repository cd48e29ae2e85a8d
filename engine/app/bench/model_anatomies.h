// The anatomies of `typodont bench models`: the molar, the lower arch, the hip's socket.
#pragma once

#include <vector>

#include "haptics/bench.h"

namespace typodont {

/// From the shipped assets. Throws Error where one is missing.
std::vector<haptics::ModelAnatomy> model_anatomies();

}  // namespace typodont
