// Creates folders and lists their files.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace typodont {

/// Creates the folder and the folders above it, unless they exist. Throws Error.
void make_folder(const std::filesystem::path& folder);
/// The files with the extension, for example ".json", sorted by name. Empty if the folder cannot be read.
std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder, std::string_view extension);
/// Like files_in(), but with the files in subfolders, sorted by path. Does not enter hidden folders and links to
/// folders, so a loop of links ends. Throws filesystem_error if a subfolder cannot be read.
std::vector<std::filesystem::path> files_below(const std::filesystem::path& folder, std::string_view extension);

}  // namespace typodont
