// What is to outlast a power cut.
#pragma once

#include <filesystem>

namespace typodont {

/// The file's content is on the disk when it returns. False where the system cannot say so (errno tells why).
bool sync_file(const std::filesystem::path& file) noexcept;
/// The same of the names in the folder that holds `file`: after a file was made, renamed or removed there.
bool sync_folder_of(const std::filesystem::path& file) noexcept;

}  // namespace typodont
