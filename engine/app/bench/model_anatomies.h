// The anatomies of `typodont bench models`: the molar, the lower arch, the hip's socket.
#pragma once

#include <vector>

#include "haptics/bench.h"

namespace typodont {

/// Loads the anatomies from the shipped assets. Throws Error if an asset is missing.
std::vector<haptics::ModelAnatomy> model_anatomies();

}  // namespace typodont
