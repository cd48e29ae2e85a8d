// Unpacks ZIP archives into a folder of this process. Not for real-time threads; throws Error.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace typodont::haptics::importing {

bool is_zip(std::string_view first_bytes);

/// Unpacks all files of an archive (stored or deflated, not encrypted, at most 4 GB). The files get numbers instead of
/// their names, so that no name in the archive can lead outside the folder. Sizes are checked before anything is
/// written.
std::vector<std::filesystem::path> unzip(const std::filesystem::path& archive, const std::filesystem::path& folder);

}  // namespace typodont::haptics::importing
