// Writes files to disk, so that they survive a power cut.
#pragma once

#include <filesystem>

namespace typodont {

/// The folder of a file; "." if the path names none.
std::filesystem::path folder_of(const std::filesystem::path& file);
/// Waits until the file is on disk. False: error in errno.
bool sync_file(const std::filesystem::path& file) noexcept;
/// Writes the folder to disk after a file in it was created, renamed or removed. False: error.
bool sync_folder_of(const std::filesystem::path& file) noexcept;

}  // namespace typodont
