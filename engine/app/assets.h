// The shipped files (assets/), and where a scene's files are looked for.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace typodont {

/// The shipped assets: $TYPODONT_ASSETS, else beside the program or in the source tree. Throws Error when not found.
std::filesystem::path assets_folder();
/// A path from a scene: relative to `beside`, then to assets/. Throws Error naming both when neither exists.
std::filesystem::path find_file(const std::filesystem::path& path, const std::filesystem::path& beside);
/// A rig file, or one of assets/rigs/ by its name: "closeup". Throws Error.
std::filesystem::path find_rig(const std::string& rig);
/// assets/KIND/NAME.json, e.g. of the kind "tools". Throws Error that lists the names there are.
std::filesystem::path named_asset(std::string_view kind, std::string_view name);

}  // namespace typodont
