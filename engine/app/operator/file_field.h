// A file's path on a page: typed, or picked from a list of what lies there. Main thread.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace typodont {

/// The list: one folder, and of its files those that are asked for.
struct FileChooser {
  std::filesystem::path folder;
  std::vector<std::filesystem::path> folders, files;  // names
  bool asked = false;                                 // to be opened in this frame
  int opened = 0;                                     // times
};

/// What lies in the folder, hidden things left out; where it cannot be read, nothing.
void look_into(FileChooser& chooser, const std::filesystem::path& folder, std::span<const std::string_view> endings);

inline constexpr std::array<std::string_view, 3> kMeshEndings = {".stl", ".ply", ".obj"};
inline constexpr std::array<std::string_view, 10> kToothEndings = {".stl", ".ply", ".obj", ".nrrd", ".nhdr",
                                                                   ".nii", ".gz",  ".hdr", ".mha",  ".mhd"};

}  // namespace typodont
