// Finds the file of the running code, because data files lie beside it.
#pragma once

#include <filesystem>

namespace typodont {

/// Path of the program or shared library that contains this code, with links resolved; empty if the path is unknown.
std::filesystem::path own_file();

}  // namespace typodont
