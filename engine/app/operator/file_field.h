// A field for a file's path: typed, or chosen from a list of files. Main thread.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace typodont {

/// The list of one folder with the files of the requested kinds.
struct FileChooser {
  std::filesystem::path folder;
  std::vector<std::filesystem::path> folders, files;  // names
  bool asked = false;                                 // open the list in this frame
  int opened = 0;                                     // number of times it was opened
};

/// Lists the folder without hidden files, and only files with these extensions (lower case: ".stl"). Empty if it cannot
/// be read.
void look_into(FileChooser& chooser, const std::filesystem::path& folder, std::span<const std::string> endings);

/// Extensions of files from which a tooth can be made: scans and meshes.
const std::vector<std::string>& tooth_endings();

}  // namespace typodont
