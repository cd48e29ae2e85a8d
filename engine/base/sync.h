// From memory to disk, to survive a power cut.
#pragma once

#include <filesystem>

namespace typodont {

/// Waits. False: error in errno.
bool sync_file(const std::filesystem::path& file) noexcept;
/// After a file was created, renamed or removed there. False: error.
bool sync_folder_of(const std::filesystem::path& file) noexcept;

}  // namespace typodont
