// Finds the shipped files (assets/) and the files that a scene names.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace typodont {

/// Folder of the shipped assets: $TYPODONT_ASSETS; if it is not set, beside the program or library, or in the source
/// tree. Throws Error.
std::filesystem::path assets_folder();
/// Folders in which the files that a scene names are searched.
struct ScenePlace {
  std::filesystem::path beside;  // relative paths are searched here first, then in assets/
  // Allowed folders: a file, with its symbolic links followed, must lie in one of them or in assets/. Empty: every
  // folder is allowed.
  std::vector<std::filesystem::path> within;
  int recordings = 0;  // number of recordings that were resumed one after another to reach this scene; it is limited

  ScenePlace() = default;
  ScenePlace(std::filesystem::path folder) : beside(std::move(folder)) {}
};

/// Finds a file that a scene names. The path is searched relative to `place` first, then relative to assets/. Throws
/// Error if the file does not exist there, or if it lies outside the allowed folders; in the second case the function
/// does not check if the file exists.
std::filesystem::path find_file(const std::filesystem::path& path, const ScenePlace& place);
/// The user's folder, ~/Typodont or $TYPODONT_HOME; it contains sessions/, scenes/ and rigs/.
std::filesystem::path user_folder();
/// Path of a rig: `rig` is a file or the name of a rig in assets/rigs/, for example "closeup". Throws Error.
std::filesystem::path find_rig(const std::string& rig);
/// Path of a scene: `scene` is a file or the name of a scene in assets/scenes/, for example "molar-caries". Throws
/// Error; if `scene` is a folder, a scan, a mesh, a volume or a session, the message names the command that opens it.
std::filesystem::path find_scene(const std::string& scene);
/// Path of assets/KIND/NAME.json; a kind is for example "tools". Throws Error that lists the available names.
std::filesystem::path named_asset(std::string_view kind, std::string_view name);

}  // namespace typodont
