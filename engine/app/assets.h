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
  // folders; a file must lie in one of them or in assets/, after following links; empty: no restriction
  std::vector<std::filesystem::path> within;
  int recordings = 0;  // length of the chain of recordings, each resumed by the next one, that leads to the scene

  ScenePlace() = default;
  ScenePlace(std::filesystem::path folder) : beside(std::move(folder)) {}
};

/// Resolves a path from a scene: relative to `place`, then to assets/. If neither path exists, throws Error that
/// names both. Also throws if the path lies outside the allowed folders; in this case it does not check if the file
/// exists.
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
