// A file's path on a page: typed, or picked from a list of what lies there. Main thread.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace typodont {

/// The list: one folder, and of its files those that are asked for.
struct FileChooser {
  std::filesystem::path folder;
  std::vector<std::filesystem::path> folders, files;  // names
  bool asked = false;                                 // to be opened in this frame
  int opened = 0;                                     // times
};

/// What lies in the folder, hidden things left out; of its files those with these endings (lower case: ".stl"). Where
/// it cannot be read, nothing.
void look_into(FileChooser& chooser, const std::filesystem::path& folder, std::span<const std::string> endings);

/// Of the files that a tooth can be made from: scans and meshes.
const std::vector<std::string>& tooth_endings();

}  // namespace typodont
