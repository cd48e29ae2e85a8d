// Unpacks ZIP archives by minizip. Not for real time; throws Error.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace typodont::haptics::importing {

bool is_zip(std::string_view first_bytes);

/// Unpacks stored or deflated files, not encrypted, at most 4 GB. The unpacked files have numbers as names, so that
/// none is written outside the folder. Sizes are checked before unpacking.
std::vector<std::filesystem::path> unzip(const std::filesystem::path& archive, const std::filesystem::path& folder);

}  // namespace typodont::haptics::importing
