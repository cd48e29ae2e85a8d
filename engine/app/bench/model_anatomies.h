// The anatomies of `typodont bench models`: the molar, the lower arch, the hip's socket.
#pragma once

#include <string>
#include <vector>

#include "haptics/bench.h"

namespace typodont {

/// Loads the anatomies from the shipped assets. `names`: the anatomies to load; empty: all. Other names are ignored.
/// Throws Error if an asset is missing.
std::vector<haptics::ModelAnatomy> model_anatomies(const std::vector<std::string>& names = {});

/// Returns the names of all tissues of `typodont bench models`, in the order in which they are measured.
std::vector<std::string> compared_tissues();

}  // namespace typodont
