// Finds the shipped files (assets/) and the files that a scene names.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace typodont {

/// Folder of the shipped assets: $TYPODONT_ASSETS, otherwise beside the program or library, or in the source tree.
/// Throws Error.
std::filesystem::path assets_folder();
/// Folders in which the files that a scene names are searched.
struct ScenePlace {
  std::filesystem::path beside;  // relative paths are searched here first, then in assets/
  // a file must lie in one of these folders or in assets/, after following links; empty: no restriction
  std::vector<std::filesystem::path> within;
  int recordings = 0;  // length of the chain of recordings, each resumed by the next one, that leads to the scene

  ScenePlace() = default;
  ScenePlace(std::filesystem::path folder) : beside(std::move(folder)) {}
};

/// Resolves a path from a scene: relative to `place`, then to assets/. Throws Error that names both paths if neither
/// exists. Also throws if the path lies outside the allowed folders, without checking if the file exists.
std::filesystem::path find_file(const std::filesystem::path& path, const ScenePlace& place);
/// The user's folder: ~/Typodont, with sessions/, scenes/ and rigs/ in it; $TYPODONT_HOME replaces it.
std::filesystem::path user_folder();
/// Path of a rig: `rig` is a file or the name of a rig in assets/rigs/, for example "closeup". Throws Error.
std::filesystem::path find_rig(const std::string& rig);
/// Path of a scene: `scene` is a file or the name of a scene in assets/scenes/, for example "molar-caries". Throws
/// Error; for a folder, a scan, a mesh, a volume or a session the message names the command that opens it.
std::filesystem::path find_scene(const std::string& scene);
/// Path of assets/KIND/NAME.json; a kind is for example "tools". Throws Error that lists the available names.
std::filesystem::path named_asset(std::string_view kind, std::string_view name);

}  // namespace typodont
