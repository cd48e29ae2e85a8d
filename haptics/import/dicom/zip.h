// Unpacks ZIP archives. Not for real time; throws Error.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace typodont::haptics::importing {

bool is_zip(std::string_view first_bytes);

/// Unpacks stored or deflated files, not encrypted, at most 4 GB. Numbers replace the file names, so none leads out of
/// the folder. Sizes are checked first.
std::vector<std::filesystem::path> unzip(const std::filesystem::path& archive, const std::filesystem::path& folder);

}  // namespace typodont::haptics::importing
