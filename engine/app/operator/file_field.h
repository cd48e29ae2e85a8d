// A path, typed or selected. Main thread only.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace typodont {

/// One folder's folders and files of the requested extensions.
struct FileChooser {
  std::filesystem::path folder;
  std::vector<std::filesystem::path> folders, files;  // names without the path of the folder
  bool asked = false;                                 // opened in this frame
  int opened = 0;                                     // number of times that the list was opened
};

/// Without hidden files. Extensions in lower case, for example ".stl". Empty if unreadable.
void list_folder(FileChooser& chooser, const std::filesystem::path& folder, std::span<const std::string> endings);

/// Scans and meshes, from which a tooth can be made.
const std::vector<std::string>& tooth_extensions();

}  // namespace typodont
