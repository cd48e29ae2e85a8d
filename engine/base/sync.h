// Makes files survive a power cut.
#pragma once

#include <filesystem>

namespace typodont {

/// Returns after the file's content has reached the disk. Returns false if the system reports an error (in errno).
bool sync_file(const std::filesystem::path& file) noexcept;
/// Syncs the folder that contains `file`. Needed after a file was created, renamed or removed there.
bool sync_folder_of(const std::filesystem::path& file) noexcept;

}  // namespace typodont
