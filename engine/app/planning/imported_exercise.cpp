#include "engine/app/planning/imported_exercise.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "engine/app/planning/volume_beside.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/tissue_volume.h"

namespace typodont {

namespace {

/// The middle of the tissue's top, m.
dvec3 top_of(const haptics::DenseTissue& tissue) {
  glm::ivec3 lo(tissue.size), hi(-1);
  for_each_voxel(tissue.size, [&](const glm::ivec3& at) {
    if (tissue.distance[tissue.at(at.x, at.y, at.z)] < 0) lo = glm::min(lo, at), hi = glm::max(hi, at);
  });
  return hi.x < 0 ? kCrownTop : tissue.frame.to_world(dvec3((lo.x + hi.x) / 2.0, (lo.y + hi.y) / 2.0, hi.z));
}

/// Makes a task in which cuts inside the boxes count as damage.
nlohmann::ordered_json task_that_protects(const std::vector<haptics::ImportRegion>& boxes) {
  nlohmann::ordered_json task = {
      {"goal",
       {{"en", "Practise on the first scan. The other scans must not be cut."},
        {"de", "Üben Sie am ersten Scan. Die anderen Scans dürfen nicht beschliffen werden."},
        {"zh", "在第一个扫描上练习，不得切削其他扫描。"}}}};
  const auto in_mm = [](const dvec3& v) {
    const dvec3 mm = v / kMillimetre;
    return nlohmann::ordered_json{mm.x, mm.y, mm.z};
  };
  for (const haptics::ImportRegion& box : boxes) {
    // Each box is enlarged by this margin, m, so that it contains the voxels of the surface.
    constexpr double kWider = 0.05e-3;
    task["protect"].push_back(
        {{"box", {{"center_mm", in_mm(0.5 * (box.lo + box.hi))}, {"size_mm", in_mm(box.hi - box.lo + 2 * kWider)}}}});
  }
  return task;
}

}  // namespace

const char* upright_rotation(Crown crown) {
  constexpr std::array kRotations{"", "x180", "y-90", "y90", "x90", "x-90"};  // in the order of the enum Crown
  return kRotations[static_cast<std::size_t>(crown)];
}

Crown crown_along(const dvec3& up) {
  const std::array<double, 6> along{up.z, -up.z, up.x, -up.x, up.y, -up.y};
  return static_cast<Crown>(std::ranges::max_element(along) - along.begin());
}

void write_imported_exercise(const ImportedExercise& exercise, haptics::Imported& imported,
                             const std::filesystem::path& file, Over over, Progress& progress) {
  std::optional<dvec3> top = exercise.top;
  if (const std::string turn = upright_rotation(exercise.crown); !turn.empty()) {
    const glm::dmat3 by = haptics::quarter_turns(turn);
    haptics::turn(imported, by);
    if (top) *top = by * *top;
  }
  haptics::DenseTissue& tissue = imported.tissue;
  const dvec3 move = kCrownTop - top.value_or(top_of(tissue));
  tissue.frame.origin += move;
  tissue.place.X_FW = tissue.place.X_FW * Pose{-move, {1, 0, 0, 0}};
  imported.report.lo += move, imported.report.hi += move;
  for (dvec3& p : imported.report.repaired) p += move;
  // Replaces old files only after all new files are complete.
  PartialFile volume(volume_beside(file), FileKind::kVolume, over), scene_file(file, FileKind::kJson, over);
  haptics::TissueVolume(tissue).save(volume.path());
  for (haptics::ImportRegion& other : imported.report.others) other.lo += move, other.hi += move;
  nlohmann::ordered_json scene = {{"name", exercise.name},
                                  {"description", exercise.description},
                                  {"tissue", {{"volume", volume.file().filename().string()}}},
                                  {"tools", {"round_012", "cylinder_010", "round_014", "explorer", "excavator_spoon"}},
                                  {"spindle", "air_turbine"},
                                  {"parts", {"haptics", "render", "sound", "debris", "record", "score"}}};
  if (!imported.report.others.empty()) scene["task"] = task_that_protects(imported.report.others);
  write_file_atomically(scene_file.path(), scene.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n",
                        FileKind::kJson);
  progress.at(1);
  volume.keep();
  scene_file.keep();
}

}  // namespace typodont
