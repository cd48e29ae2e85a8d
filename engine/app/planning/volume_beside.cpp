#include "engine/app/planning/volume_beside.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/base/error.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

/// True if the scene `file` uses the volume `site` beside it. Only such a volume may be replaced.
bool names_volume(const fs::path& file, const fs::path& site) {
  std::error_code code;
  if (!fs::is_regular_file(file, code)) return false;
  std::ifstream in(file, std::ios::binary);
  const auto text = nlohmann::ordered_json::parse(in, nullptr, /*allow_exceptions=*/false);
  const auto tissue = text.find("tissue");
  return tissue != text.end() && tissue->is_object() && tissue->contains("volume") &&
         (*tissue)["volume"] == site.filename().string();
}

}  // namespace

fs::path volume_beside(const fs::path& file) {
  return fs::path(file).replace_extension(".vdb");
}

void require_volume_beside(const fs::path& file, Over over) {
  const fs::path site = volume_beside(file);
  try {
    (void)nlohmann::json(site.filename().string()).dump();
  } catch (const nlohmann::json::type_error&) {
    throw Error(file.string(), "", "a name that is not UTF-8",
                "one that the exercise can state as the name of its volume");
  }
  require_output(site, FileKind::kVolume, over);
  std::error_code code;
  if (fs::exists(site, code) && !names_volume(file, site))
    throw Error(site.string(), "", "a volume that does not belong to " + file.filename().string(),
                "another name for the exercise, because its tissue is written beside it");
}

}  // namespace typodont
