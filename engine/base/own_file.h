// Where the running code lies; data files are searched in its folder.
#pragma once

#include <filesystem>

namespace typodont {

/// Program or library, links resolved. Empty if unknown.
std::filesystem::path own_file();

}  // namespace typodont
