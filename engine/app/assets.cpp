#include "engine/app/assets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/lower_case.h"
#include "engine/base/own_file.h"
#include "haptics/import/import.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

std::string names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::path& file : files_in(folder, ".json")) names.push_back(file.stem().string());
  return fmt::format("one of {}", fmt::join(names, ", "));
}

}  // namespace

fs::path assets_folder() {
  std::error_code code;
  if (const char* set = std::getenv("TYPODONT_ASSETS")) {
    if (!fs::is_directory(fs::path(set) / "tools", code)) {
      throw Error(set, "", "no assets there", "the folder named by TYPODONT_ASSETS to hold tools/, scenes/ …");
    }
    return set;
  }
  // In a build folder, the program is build/release/typodont, and assets/ is two levels above. In an installation, the
  // program is bin/typodont or the library lib/libtypodont.so, and the assets are in share/typodont/assets.
  const fs::path program = own_file().parent_path();
  for (fs::path up = program; !up.empty(); up = up.parent_path()) {
    if (fs::is_directory(up / "assets" / "tools", code)) return up / "assets";
    if (fs::is_directory(up / "share/typodont/assets/tools", code)) return up / "share/typodont/assets";
    if (up == up.root_path()) break;
  }
  throw Error(program.string(), "", "no assets beside the program",
              "the assets folder, or its place in TYPODONT_ASSETS");
}

namespace {

std::optional<fs::path> shipped(const fs::path& folder, std::string_view name) {
  const fs::path file = folder / (std::string(name) + ".json");
  const bool plain = !name.empty() && name.find('/') == std::string_view::npos && name != "..";
  std::error_code code;
  return plain && fs::is_regular_file(file, code) ? std::optional(file) : std::nullopt;
}

/// Returns `file` if this file exists, otherwise the path assets/KIND/FILE.json, where KIND is the value of `kind`.
/// Throws Error if neither file exists. `noun`: what the message calls such a file, for example "rig".
fs::path file_or_shipped(const std::string& file, std::string_view kind, std::string_view noun) {
  std::error_code code;
  if (fs::exists(file, code)) return file;
  const fs::path folder = assets_folder() / kind;
  if (const auto found = shipped(folder, file)) return *found;
  throw Error(file, "", "no such file", fmt::format("a {} file, or {}", noun, names_in(folder)));
}

/// Throws Error if the file is not a scene but the input of another command, for example a scan or a mesh. The message
/// names the command that opens the file.
void refuse_other_input(const fs::path& file) {
  std::error_code code;
  const std::string ending = lower_case(file.extension().string());
  const auto is_one_of = [&](const std::vector<std::string>& endings) {
    return std::ranges::find(endings, ending) != endings.end();
  };
  if (ending == ".vdb") {
    throw Error(file.string(), "", "a tissue volume", "a scene (JSON) that names the volume in \"tissue\"");
  }
  if (ending == ".h5") throw Error(file.string(), "", "a session", "a scene (JSON); `typodont replay` shows a session");
  if (is_one_of(haptics::mesh_endings()) || is_one_of(haptics::scan_endings()) || fs::is_directory(file, code) ||
      (fs::is_regular_file(file, code) && haptics::is_dicom(file))) {
    throw Error(file.string(), "", "a scan, a mesh or a folder",
                "a scene (JSON); `typodont import` makes a tissue volume from a scan or mesh");
  }
}

}  // namespace

fs::path find_rig(const std::string& rig) {
  return file_or_shipped(rig, "rigs", "rig");
}

fs::path find_scene(const std::string& scene) {
  const fs::path file = file_or_shipped(scene, "scenes", "scene");
  refuse_other_input(file);
  return file;
}

fs::path user_folder() {
  if (const char* set = std::getenv("TYPODONT_HOME"); set && *set) return set;
  const char* home = std::getenv("HOME");
  return fs::path(home && *home ? home : ".") / "Typodont";
}

namespace {

/// True if `path` is inside `folder`, after all symbolic links are resolved. The last parts of `path` need not exist.
bool lies_in(const fs::path& path, const fs::path& folder) {
  std::error_code code;
  const fs::path file = fs::weakly_canonical(fs::absolute(path), code);
  if (code) return false;
  const fs::path real = fs::weakly_canonical(fs::absolute(folder), code);
  if (code || real.empty()) return false;
  return std::mismatch(real.begin(), real.end(), file.begin(), file.end()).first == real.end();
}

/// True if the text of `path` begins with the text of `folder`. Symbolic links are not followed, because links inside
/// the assets are trusted.
bool named_in(const fs::path& path, const fs::path& folder) {
  const fs::path file = fs::absolute(path).lexically_normal(), at = fs::absolute(folder).lexically_normal();
  return std::mismatch(at.begin(), at.end(), file.begin(), file.end()).first == at.end();
}

void require_allowed(const fs::path& path, const ScenePlace& place) {
  if (place.within.empty() || named_in(path, assets_folder()) || lies_in(path, assets_folder())) return;
  std::string folders;
  for (const fs::path& folder : place.within) {
    if (lies_in(path, folder)) return;
    folders += (folders.empty() ? "" : ", ") + folder.string();
  }
  throw Error(
      path.string(), "", "a recording that names a file outside its folder",
      fmt::format("it in {} or in assets/; TYPODONT_FILES allows more folders, with ':' between them", folders));
}

}  // namespace

namespace {

/// The file that `path` names; empty: no such file.
std::optional<fs::path> searched(const fs::path& path, const ScenePlace& place) {
  if (place.checked) {
    const auto copy = place.checked->find(path.string());
    if (copy != place.checked->end()) return copy->second;
  }
  std::error_code code;
  if (path.is_absolute()) {
    require_allowed(path, place);
    return fs::exists(path, code) ? std::optional(path) : std::nullopt;
  }
  for (const fs::path& folder : {place.beside, assets_folder()}) {
    const fs::path file = folder / path;
    // A path such as "../../x" or a symbolic link can lead out of `folder`. The file must then be in an allowed folder.
    if (!place.within.empty() && !lies_in(file, folder)) require_allowed(file, place);
    if (!fs::exists(file, code)) continue;
    require_allowed(file, place);
    return file;
  }
  return std::nullopt;
}

std::string searched_places(const fs::path& path, const ScenePlace& place) {
  if (path.is_absolute()) return "a readable file";
  return fmt::format("it in {} or {}", place.beside.empty() ? "." : place.beside.string(), assets_folder().string());
}

}  // namespace

fs::path find_file(const fs::path& path, const ScenePlace& place) {
  if (auto file = searched(path, place)) return *file;
  throw Error(path.string(), "", "no such file", searched_places(path, place));
}

fs::path find_file(const Json& name, const ScenePlace& place) {
  const fs::path path = name.string();
  if (auto file = searched(path, place)) return *file;
  name.fail(fmt::format("no file \"{}\"", path.string()), searched_places(path, place));
}

fs::path named_asset(std::string_view kind, std::string_view name) {
  const fs::path folder = assets_folder() / kind;
  if (auto file = shipped(folder, name)) return *file;
  throw Error(folder.string(), "", fmt::format("nothing named \"{}\"", name), names_in(folder));
}

std::string asset_name(std::string_view kind, const Json& name) {
  const fs::path folder = assets_folder() / kind;
  if (!shipped(folder, name.string())) name.fail(names_in(folder));
  return name.string();
}

}  // namespace typodont
