// The shipped files (assets/), and where a scene's files are looked for.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace typodont {

/// The shipped assets: $TYPODONT_ASSETS, else beside the program or library, or in the source tree. Throws Error.
std::filesystem::path assets_folder();
/// Where the files that a scene names may lie.
struct ScenePlace {
  std::filesystem::path beside;               // relative paths start here, then in assets/
  std::vector<std::filesystem::path> within;  // empty: anywhere; else in these folders or in assets/, links followed
  int recordings = 0;                         // out of which the scene was read, one naming the other

  ScenePlace() = default;
  ScenePlace(std::filesystem::path folder) : beside(std::move(folder)) {}
};

/// A path from a scene: relative to `place`, then to assets/. Throws Error naming both when neither exists, and where
/// the file lies outside of what the place allows, without looking whether it is there.
std::filesystem::path find_file(const std::filesystem::path& path, const ScenePlace& place);
/// The user's folder: ~/Typodont, with sessions/, scenes/ and rigs/ in it; $TYPODONT_HOME elsewhere.
std::filesystem::path user_folder();
/// A rig file, or one of assets/rigs/ by its name: "closeup". Throws Error.
std::filesystem::path find_rig(const std::string& rig);
/// assets/KIND/NAME.json, e.g. of the kind "tools". Throws Error that lists the names there are.
std::filesystem::path named_asset(std::string_view kind, std::string_view name);

}  // namespace typodont
