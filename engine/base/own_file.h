// Finds the file that contains the running code. The program searches for its data files in the folder of this file.
#pragma once

#include <filesystem>

namespace typodont {

/// Returns the path of the program or shared library that contains this code, with links resolved. The path is empty if
/// it is unknown.
std::filesystem::path own_file();

}  // namespace typodont
