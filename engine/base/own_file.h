// Path of the running program or library, beside which its data files are searched.
#pragma once

#include <filesystem>

namespace typodont {

/// Path of the program or library that contains this code, with links resolved. Empty if unknown.
std::filesystem::path own_file();

}  // namespace typodont
