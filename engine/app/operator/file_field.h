// A field for a path, which the user types or selects. Main thread only.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace typodont {

/// A folder's subfolders, and its files with the requested extensions.
struct FileChooser {
  std::filesystem::path folder;
  std::vector<std::filesystem::path> folders, files;  // names without the path of the folder
  bool asked = false;                                 // true: the popup with the list of files must be opened
  int opened = 0;                                     // number of times that the popup was opened
};

/// Lists a folder without hidden files. `endings`: file extensions in lower case, for example ".stl". Empty if the
/// folder can't be read.
void list_folder(FileChooser& chooser, const std::filesystem::path& folder, std::span<const std::string> endings);

/// File extensions of scans and meshes usable for a tooth.
const std::vector<std::string>& tooth_extensions();

}  // namespace typodont
