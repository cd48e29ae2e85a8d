// A field for a file's path. The user types the path, or selects it from a list of files. Main thread.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace typodont {

/// A list of one folder with the files of the requested kinds.
struct FileChooser {
  std::filesystem::path folder;
  std::vector<std::filesystem::path> folders, files;  // names without the folder
  bool asked = false;                                 // true: the list opens in the present frame
  int opened = 0;                                     // number of times that the list was opened
};

/// Lists the folder without hidden files; lists only files with these extensions (lower case: ".stl"). The list is
/// empty if the folder cannot be read.
void list_folder(FileChooser& chooser, const std::filesystem::path& folder, std::span<const std::string> endings);

/// Extensions of files from which a tooth can be made: scans and meshes.
const std::vector<std::string>& tooth_extensions();

}  // namespace typodont
