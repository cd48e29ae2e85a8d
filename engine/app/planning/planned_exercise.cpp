#include "engine/app/planning/planned_exercise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "engine/app/planning/scene_text.h"
#include "engine/app/planning/volume_beside.h"
#include "engine/app/scene/implant_scene.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/partial_file.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
using Text = nlohmann::ordered_json;

// Implant's upper end (platform) in shipped scenes, m, frame W.
constexpr dvec3 kPlatform{6.8e-3, 5.8e-3, 18e-3};
constexpr double kSite = 15e-3;  // m, distance from the implant within which tissue is copied
// Largest voxel of the copy, m, as in shipped scenes.
constexpr double kMaxVoxel = 0.15e-3;

Text direction(const dvec3& v) {
  const auto rounded = [](double c) { return std::round(c * 1e6) / 1e6; };
  return {rounded(v.x), rounded(v.y), rounded(v.z)};
}

Text load_text(const fs::path& file) {
  return Text::parse(Json::load(file).text());
}

/// Copies the tissue around the planned implant and moves it by `move` (m). Voxels are at most kMaxVoxel; with larger
/// ones, a widening drill would get stuck at the wall. Labels, hardness and colours come from the nearest voxel.
haptics::TissueVolume site_of(const haptics::TissueVolume& volume, const session::ImplantPlan& plan,
                              const dvec3& move) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  const VoxelFrame frame = volume.frame();
  const dvec3 a = glm::min(plan.entry_W, plan.apex_W()) - kSite, b = glm::max(plan.entry_W, plan.apex_W()) + kSite;
  lo = glm::max(lo, glm::ivec3(glm::floor(frame.to_voxels(a))));
  hi = glm::min(hi, glm::ivec3(glm::ceil(frame.to_voxels(b))));
  const DenseCopy copy = dense_copy(volume, lo, hi - lo + 1);

  const int n = static_cast<int>(std::ceil(frame.voxel / kMaxVoxel));
  haptics::DenseTissue site;
  site.frame = {copy.frame.origin + move, frame.voxel / n};
  site.size = n * (copy.field.size - 1) + 1;
  site.band = volume.band();
  site.exact_outside = volume.exact_outside();
  site.place = volume.place();
  site.place.X_FW = site.place.X_FW * Pose{-move, {1, 0, 0, 0}};
  site.distance.resize(site.at(site.size.x - 1, site.size.y - 1, site.size.z - 1) + 1);
  site.tissue.resize(site.distance.size());
  if (!copy.hardness.empty()) site.hardness.resize(site.distance.size());
  if (!copy.color.empty()) site.color.resize(site.distance.size());
  for_each_voxel(site.size, [&](const glm::ivec3& p) {
    const dvec3 place = dvec3(p) / static_cast<double>(n);
    const glm::ivec3 near(glm::round(place));
    const std::size_t nearest = copy.field.at(near.x, near.y, near.z);
    // The copied tissue ends two voxels inside the box, so that its surface is closed.
    const glm::ivec3 in = glm::min(p, site.size - 1 - p);
    const double closed = (2 - std::min({in.x, in.y, in.z})) * site.frame.voxel;
    const std::size_t i = site.at(p.x, p.y, p.z);
    site.distance[i] = static_cast<float>(std::max(copy.field.sample(place) * frame.voxel, closed));
    site.tissue[i] = copy.tissue[nearest];
    if (!copy.hardness.empty()) site.hardness[i] = copy.hardness[nearest];
    if (!copy.color.empty()) site.color[i] = copy.color[nearest];
  });
  return haptics::TissueVolume(site);
}

/// Replaces the target values of exercise.json by those of this implant.
Text rules_for(Text rules, const PlannedExercise& exercise, bool canal) {
  Text made = Text::array();
  for (Text& rule : rules) {
    const std::string name = rule["name"];
    if (name == "canal_distance_mm" && !canal) continue;
    if (name == "bed_depth_mm") rule["target"] = exercise.plan.length / kMillimetre;
    if (name == "bed_diameter_mm") rule["target"] = exercise.plan.bed_diameter / kMillimetre;
    made.push_back(rule);
  }
  return made;
}

}  // namespace

void require_planned_exercise(const Scene& scene, const fs::path& file, Over over) {
  require_output(file, FileKind::kJson, over);
  const fs::path source = volume_file(scene);
  if (source.empty()) return;
  const fs::path site = volume_beside(file);
  std::error_code missing;
  if (fs::equivalent(source, site, missing))
    throw Error(file.string(), "", "a name whose volume " + site.filename().string() + " is the jaw itself",
                "another name, because the tissue of the site is written beside the exercise");
  require_volume_beside(file, over);
}

void write_planned_exercise(const PlannedExercise& exercise, const fs::path& file, Over over, Progress& progress) {
  const ImplantPlanner& planner = *exercise.planner;
  const Scene& base = planner.scene();
  require_planned_exercise(base, file, over);
  session::ImplantPlan plan = exercise.plan;
  NerveCanal canal = planner.canal_near(plan);
  Text scene = {{"name", exercise.name}};
  const bool cut_out = !volume_file(base).empty();
  const dvec3 move = cut_out ? kPlatform - plan.entry_W : dvec3(0);
  const fs::path volume_name = volume_beside(file).filename();
  const Text base_text = scene_for_other_folder(base);
  scene["description"] = fmt::format("{}; {}", base_text.value("description", base.name), exercise.procedure.name);
  if (cut_out) {
    scene["tissue"] = {{"volume", volume_name.string()}};
    plan.entry_W += move;
    for (dvec3& p : canal.path_W) p += move;
  } else {
    for (const char* key : {"tissue", "paint", "paint_file", "prepare"})
      if (base_text.contains(key)) scene[key] = base_text[key];
  }
  const Text common = load_text(implant_exercise_file());
  const Text procedure = load_text(find_file(exercise.procedure.path, base.place));
  scene["tool_set"] = common["tool_set"];
  scene["tools"] = Text::array();
  Text steps = Text::array();
  for (const Text& phase : procedure["phases"]) {
    if (std::find(scene["tools"].begin(), scene["tools"].end(), phase["tool"]) == scene["tools"].end())
      scene["tools"].push_back(phase["tool"]);
    Text step = phase["name"];
    step["done"] = "phase";
    steps.push_back(std::move(step));
  }
  for (const auto& [key, value] : common.items())
    if (key != "task" && key != "tool_set") scene[key] = value;
  scene["implant"] = {{"procedure", exercise.procedure.path},
                      {"plan", {{"entry_mm", millimetres_text(plan.entry_W)}, {"axis", direction(plan.axis_W)}}}};
  if (base_text.contains("implant") && base_text["implant"].contains("neighbours")) {
    Text& roots = scene["implant"]["neighbours"] = base_text["implant"]["neighbours"];
    for (std::size_t i = 0; i < base.implant->neighbours.size(); ++i) {
      roots[i]["a_mm"] = millimetres_text(base.implant->neighbours[i].a_W + move);
      roots[i]["b_mm"] = millimetres_text(base.implant->neighbours[i].b_W + move);
    }
  }
  const bool own_canal = base_text["tissue"].contains("bone") && base_text["tissue"]["bone"].contains("canal");
  if (!canal.path_W.empty() && !own_canal) {
    Text path = Text::array();
    for (const dvec3& p : canal.path_W) path.push_back(millimetres_text(p));
    scene["implant"]["canal"] = {{"path_mm", path}, {"diameter_mm", 2 * canal.radius / kMillimetre}};
  }
  Text task = common["task"];
  scene["task"] = {{"title", exercise.name}, {"goal", task["goal"]}, {"steps", steps}};
  scene["task"]["axis"] = direction(-plan.axis_W);
  for (const auto& [key, value] : task.items())
    if (key != "goal" && key != "rules") scene["task"][key] = value;
  scene["task"]["rules"] = rules_for(task["rules"], exercise, !canal.path_W.empty());
  progress.at(0.1);

  // Both files are checked before either replaces an older one.
  const std::string text = scene.dump(2) + "\n";
  const Scene parsed = parse_scene(Json::parse(text, file.filename().string()), file, base.place);
  std::optional<haptics::TissueVolume> site;
  if (cut_out) site.emplace(site_of(planner.volume(), exercise.plan, move));
  check_plan(*parsed.implant, site ? *site : planner.volume(), file);
  PartialFile made(file, FileKind::kJson, over);
  write_file_atomically(made.path(), text, FileKind::kJson);
  std::optional<PartialFile> volume;
  if (site) {
    volume.emplace(volume_beside(file), FileKind::kVolume, over);
    site->save(volume->path());
  }
  progress.at(1);
  if (volume) volume->keep();
  made.keep();
}

}  // namespace typodont
