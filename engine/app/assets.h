// Functions that find the shipped files (assets/) and the files to which a scene refers.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/json.h"

namespace typodont {

/// The folder of the shipped assets. The environment variable TYPODONT_ASSETS names it; without this variable, the
/// function searches beside the program or library and in the folders above. Throws Error.
std::filesystem::path assets_folder();
/// Folders in which the program searches for the files to which a scene refers.
struct ScenePlace {
  /// The first folder in which the program searches for a file with a relative path; assets/ is the second.
  std::filesystem::path beside;
  // Allowed folders: a file, with its symbolic links resolved, must be in one of them or in assets/. Empty: every
  // folder is allowed.
  std::vector<std::filesystem::path> within;
  /// Number of recordings that were opened, one after the other, to find this scene; at most 32. The scene of a
  /// recording can refer to an earlier recording, which it continues.
  int recordings = 0;
  /// Private copies of the files that a recording lists, checked by their SHA-256; the key is the name in the scene.
  /// Null: the scene is not from a recording.
  std::shared_ptr<const std::map<std::string, std::filesystem::path>> checked;

  ScenePlace() = default;
  ScenePlace(std::filesystem::path folder) : beside(std::move(folder)) {}
};

/// Finds a file to which a scene refers: in place.checked, else in the folder of `place`, else in assets/. Throws Error
/// if it does not exist, or if it is outside the allowed folders; in the second case, the error does not reveal whether
/// the file exists.
std::filesystem::path find_file(const std::filesystem::path& path, const ScenePlace& place);
/// Finds the file that `name`, a text in a JSON file, names. An Error states where in the JSON file this text is.
std::filesystem::path find_file(const Json& name, const ScenePlace& place);
/// ~/Typodont or $TYPODONT_HOME; contains sessions/, scenes/ and rigs/.
std::filesystem::path user_folder();
/// Finds a rig file. `rig` is a path, or the name of a rig in assets/rigs/, for example "closeup". Throws Error.
std::filesystem::path find_rig(const std::string& rig);
/// Finds a scene file. `scene` is a path, or the name of a scene in assets/scenes/, for example "molar-caries". Throws
/// Error. For other kinds of input (a folder, scan, mesh, volume or session), the message names the command that opens
/// it.
std::filesystem::path find_scene(const std::string& scene);
/// Finds the file assets/KIND/NAME.json. A kind is for example "tools". Throws Error that lists the available names.
std::filesystem::path named_asset(std::string_view kind, std::string_view name);
/// Returns the text `name` of a JSON file. Throws Error, with the place of this text, if no such asset exists.
std::string asset_name(std::string_view kind, const Json& name);

}  // namespace typodont
