#include "engine/app/planning/scene_text.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "engine/base/units.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
using Text = nlohmann::ordered_json;

void make_absolute(Text& json, const char* key, const fs::path& folder) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_string()) return;
  const fs::path beside = folder / json[key].get<std::string>();
  std::error_code code;
  if (fs::exists(beside, code)) json[key] = fs::absolute(beside).string();
}

/// Makes the paths of a volume, a session or a mesh in this JSON object absolute.
void make_absolute(Text& source, const fs::path& folder) {
  for (const char* key : {"volume", "session"}) make_absolute(source, key, folder);
  for (const char* key : {"mesh", "bone"}) {
    if (!source.is_object() || !source.contains(key)) continue;
    Text& object = source[key];
    if (object.is_object() && object.contains("mesh")) make_absolute(object["mesh"], "file", folder);
    make_absolute(object, "file", folder);
  }
}

}  // namespace

Text millimetres_text(const dvec3& p) {
  const auto rounded = [](double v) { return std::round(v / kMillimetre * 1000) / 1000; };
  return {rounded(p.x), rounded(p.y), rounded(p.z)};
}

Text scene_for_other_folder(const Scene& scene) {
  Text text = Text::parse(scene.text);
  const fs::path& folder = scene.place.beside;
  if (text.contains("tissue")) make_absolute(text["tissue"], folder);
  make_absolute(text, "paint_file", folder);
  if (text.contains("surroundings")) {
    make_absolute(text["surroundings"], folder);
    make_absolute(text["surroundings"], "row", folder);
  }
  if (text.contains("task") && text["task"].contains("ideal")) make_absolute(text["task"]["ideal"], folder);
  return text;
}

}  // namespace typodont
