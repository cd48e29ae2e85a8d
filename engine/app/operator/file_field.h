// A field for the path of a file. The user types the path or selects it from a list. Main thread only.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace typodont {

/// A list of the folders and files in one folder. Only files with the requested extensions are listed.
struct FileChooser {
  std::filesystem::path folder;
  std::vector<std::filesystem::path> folders, files;  // names without the path of the folder
  bool asked = false;                                 // true: the list will be opened in the present frame
  int opened = 0;                                     // number of times that the list was opened
};

/// Fills the list with the content of the folder, without hidden files. Only files with these extensions are listed (in
/// lower case, for example ".stl"). The list is empty if the folder cannot be read.
void list_folder(FileChooser& chooser, const std::filesystem::path& folder, std::span<const std::string> endings);

/// Returns the extensions of files from which a tooth can be made: scans and meshes.
const std::vector<std::string>& tooth_extensions();

}  // namespace typodont
