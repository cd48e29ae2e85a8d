#include "engine/app/assets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "engine/base/error.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

std::string names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
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
  // build/release/typodont → assets/ two levels up; an installed bin/typodont → share/typodont/assets.
  const fs::path program = fs::read_symlink("/proc/self/exe", code).parent_path();
  for (fs::path up = program; !up.empty(); up = up.parent_path()) {
    if (fs::is_directory(up / "assets" / "tools", code)) return up / "assets";
    if (fs::is_directory(up / "share/typodont/assets/tools", code)) return up / "share/typodont/assets";
    if (up == up.root_path()) break;
  }
  throw Error(program.string(), "", "no assets beside the program",
              "the assets folder, or its place in TYPODONT_ASSETS");
}

fs::path find_rig(const std::string& rig) {
  std::error_code code;
  if (fs::exists(rig, code)) return rig;
  const fs::path shipped = assets_folder() / "rigs" / (rig + ".json");
  if (rig.find('/') == std::string::npos && fs::exists(shipped, code)) return shipped;
  throw Error(rig, "", "no such file",
              fmt::format("a rig file, or the name of one in {}", shipped.parent_path().string()));
}

fs::path find_file(const fs::path& path, const fs::path& beside) {
  std::error_code code;
  if (path.is_absolute()) {
    if (!fs::exists(path, code)) throw Error(path.string(), "", "no such file", "a readable file");
    return path;
  }
  for (const fs::path& folder : {beside, assets_folder()}) {
    if (fs::exists(folder / path, code)) return folder / path;
  }
  throw Error(path.string(), "", "no such file",
              fmt::format("it in {} or {}", beside.empty() ? "." : beside.string(), assets_folder().string()));
}

fs::path named_asset(std::string_view kind, std::string_view name) {
  const fs::path folder = assets_folder() / kind;
  const fs::path file = folder / (std::string(name) + ".json");
  const bool plain = !name.empty() && name.find('/') == std::string_view::npos && name != "..";
  std::error_code code;
  if (!plain || !fs::is_regular_file(file, code)) {
    throw Error(folder.string(), "", fmt::format("nothing named \"{}\"", name), names_in(folder));
  }
  return file;
}

}  // namespace typodont
