// Writes files and folders from the system's memory to the disk, so that they survive a power cut.
#pragma once

#include <filesystem>

namespace typodont {

/// Waits until the file's content has reached the disk. Returns false if the system reports an error (in errno).
bool sync_file(const std::filesystem::path& file) noexcept;
/// Syncs the folder that contains `file`. Call after a file was created, renamed or removed there. Returns false on an
/// error.
bool sync_folder_of(const std::filesystem::path& file) noexcept;

}  // namespace typodont
