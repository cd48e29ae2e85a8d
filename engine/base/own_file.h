// Where the running code came from: its files lie beside it.
#pragma once

#include <filesystem>

namespace typodont {

/// The program, or the shared library, that holds this code. Links followed; empty where the system does not tell.
std::filesystem::path own_file();

}  // namespace typodont
