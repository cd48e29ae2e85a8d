#include "engine/app/scene/implant_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "engine/app/tissue/bone_tissue.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/implant_tool.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

constexpr double kRpm = 2 * kPi / 60;  // rad/s, one revolution per minute
// Depth behind the bed's wall, m. If there is no bone at this depth, the wall has an opening.
constexpr double kBehind = 0.3e-3;
constexpr int kAround = 24;

/// The voxels in a box around the planned implant.
class Around {
 public:
  Around(const haptics::TissueVolume& volume, const session::ImplantPlan& plan) : frame_(volume.frame()) {
    const dvec3 reach(2 * plan.diameter), a = plan.entry_W, b = plan.apex_W();
    lo_ = glm::ivec3(glm::floor(frame_.to_voxels(glm::min(a, b) - reach)));
    const glm::ivec3 hi(glm::ceil(frame_.to_voxels(glm::max(a, b) + reach)));
    box_ = dense_copy(volume, lo_, hi - lo_ + 1);
  }
  bool is_bone(const dvec3& p_W) const { return typodont::is_bone(tissue_at(p_W)); }
  bool is_tooth(const dvec3& p_W) const { return typodont::is_tooth(tissue_at(p_W)); }
  /// Calls visit(p_W) for every voxel of the box.
  template <class Visit>
  void for_each(Visit visit) const {
    const glm::ivec3 size = box_.field.size;
    glm::ivec3 p;
    for (p.x = 0; p.x < size.x; ++p.x)
      for (p.y = 0; p.y < size.y; ++p.y)
        for (p.z = 0; p.z < size.z; ++p.z) visit(frame_.to_world(dvec3(lo_ + p)));
  }
  double voxel() const { return frame_.voxel; }

 private:
  /// Tissue of the nearest voxel; air outside of the box.
  Tissue tissue_at(const dvec3& p_W) const {
    const glm::ivec3 p = glm::ivec3(glm::round(frame_.to_voxels(p_W))) - lo_;
    if (glm::any(glm::lessThan(p, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(p, box_.field.size)))
      return Tissue::kAir;
    const std::size_t i = box_.field.at(p.x, p.y, p.z);
    return box_.field.distance[i] < 0 ? box_.tissue[i] : Tissue::kAir;
  }
  // Frame of the whole volume, so that the nearest voxel is the same as in the volume.
  VoxelFrame frame_;
  glm::ivec3 lo_;
  DenseCopy box_;
};

dquat across(const dvec3& axis) {
  return rotation_between({0, 0, -1}, axis);
}
dvec3 around(int i, double r) {
  const double a = 2 * kPi * i / kAround;
  return {r * std::cos(a), r * std::sin(a), 0};
}

}  // namespace

haptics::Tool load_set_tool(const fs::path& folder, const Json& name) {
  const std::string wanted = name.string();
  std::vector<std::string> names;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  if (std::find(names.begin(), names.end(), wanted) == names.end()) {
    name.fail(fmt::format("\"{}\", which is not in the set {}", wanted, folder.filename().string()),
              fmt::format("one of: {}", fmt::join(names, ", ")));
  }
  haptics::Tool tool = haptics::read_tool(Json::load(folder / (wanted + ".json")));
  tool.name = wanted;
  return tool;
}

session::ImplantTask read_implant(const Json& json, const Json& tissue, std::span<const haptics::Tool> tools,
                                  const ScenePlace& place) {
  json.allow_only({"procedure", "plan", "neighbours", "canal"});
  session::ImplantTask task;
  const Json procedure = Json::load(find_file(json["procedure"], place));
  procedure.allow_only({"name", "implant", "bed_diameter_mm", "phases", "limits", "source"});
  const auto tool_named = [&](const Json& name) {
    const auto found =
        std::find_if(tools.begin(), tools.end(), [&](const haptics::Tool& tool) { return tool.name == name.string(); });
    if (found == tools.end()) {
      std::vector<std::string> names;
      for (const haptics::Tool& tool : tools) names.push_back(tool.name);
      name.fail(fmt::format("\"{}\", which is not among the scene's tools", name.string()),
                fmt::format("one of: {}", fmt::join(names, ", ")));
    }
    return static_cast<std::uint32_t>(found - tools.begin());
  };
  const Json plan = json["plan"];
  plan.allow_only({"entry_mm", "axis"});
  const haptics::Tool& implant = tools[tool_named(procedure["implant"])];
  if (!implant.implant || implant.implant->kind != haptics::ImplantToolKind::kImplant)
    procedure["implant"].fail("a tool of the kind \"implant\"");
  task.plan.entry_W = plan["entry_mm"].vec3() * kMillimetre;
  const dvec3 axis = plan["axis"].vec3();
  if (!(glm::length(axis) > 1e-9)) plan["axis"].fail("a direction into the bone, not zero");
  task.plan.axis_W = glm::normalize(axis);
  task.plan.length = implant.length;
  task.plan.diameter = implant.diameter;
  task.plan.bed_diameter = procedure["bed_diameter_mm"].number(0.5, 10) * kMillimetre;
  for (const Json& item : procedure["phases"].items()) {
    item.allow_only({"name", "deed", "tool", "depth_mm", "volume_mm3"});
    session::ImplantPhase phase;
    phase.name = session::read_task_text(item["name"]);
    const auto deed = session::implant_action_named(item["deed"].string());
    if (!deed) item["deed"].fail("smooth, mark, drill, check, tap, place or close");
    phase.deed = *deed;
    phase.tool = tool_named(item["tool"]);
    phase.depth = item.number_or("depth_mm", 0, -5, 30) * kMillimetre;
    phase.volume = item.number_or("volume_mm3", 0, 0, 1000) * kCubicMillimetre;
    if (const auto& tool = tools[phase.tool].implant) {
      phase.speed = tool->speed;
      phase.irrigated = tool->irrigated;
    } else {
      item["tool"].fail("a tool with an \"implant\" block");
    }
    task.phases.push_back(std::move(phase));
  }
  if (task.phases.empty()) procedure["phases"].fail("at least one phase");
  const Json limits = procedure["limits"];
  limits.allow_only({"force_N", "angle_deg", "too_deep_mm", "canal_mm", "source"});
  task.max_force = limits["force_N"].number(0.1, 200);
  task.max_angle = limits["angle_deg"].number(0.1, 45) * kDegree;
  task.depth_tolerance = limits["too_deep_mm"].number(0.05, 5) * kMillimetre;
  task.canal_clearance = limits["canal_mm"].number(0, 10) * kMillimetre;
  for (const haptics::Tool& tool : tools) {
    task.tip.push_back(tool.half());
    task.radius.push_back(tool.radius());
  }
  NerveCanal canal = read_nerve_canal(tissue);
  if (const auto own = json.find("canal")) {
    if (!canal.path_W.empty()) own->fail("a canal here and one in the tissue's bone", "one of them");
    own->allow_only({"path_mm", "diameter_mm"});
    canal = read_canal(*own);
  }
  task.canal_W = canal.path_W;
  task.canal_radius = canal.radius;
  if (const auto neighbours = json.find("neighbours")) {
    for (const Json& root : neighbours->items()) {
      root.allow_only({"a_mm", "b_mm", "radius_mm"});
      task.neighbours.push_back({root["a_mm"].vec3() * kMillimetre, root["b_mm"].vec3() * kMillimetre,
                                 root["radius_mm"].number(0.1, 10) * kMillimetre});
    }
  }
  return task;
}

fs::path implant_exercise_file() {
  return assets_folder() / "implants" / "exercise.json";
}

void require_greys(const haptics::TissueVolume& tissue, const fs::path& file) {
  if (tissue.graded()) return;
  throw Error(file.string(), "tissue", "tissue without grey values: every voxel has its tissue's own hardness",
              "bone with a hardness per voxel, e.g. {\"bone\": …} or a scan that was imported with its grey values");
}

void check_plan(const session::ImplantTask& task, const haptics::TissueVolume& tissue, const fs::path& file) {
  require_greys(tissue, file);
  const Around bone(tissue, task.plan);
  for_thread_surface(task.plan, [&](const dvec3& p_W, double depth) {
    if (bone.is_bone(p_W)) return true;
    const dvec3 mm = p_W / kMillimetre;
    throw Error(file.string(), "implant.plan",
                fmt::format("an implant that leaves the jaw at ({:.1f}, {:.1f}, {:.1f}) mm, {:.1f} mm deep", mm.x, mm.y,
                            mm.z, depth / kMillimetre),
                "an implant with bone all around it");
  });
}

void measure_bed(const session::ImplantTask& task, const haptics::TissueVolume& after,
                 session::ImplantMeasures& measures) {
  const session::ImplantPlan& plan = task.plan;
  const Around bone(after, plan);
  const dquat R = across(plan.axis_W);
  session::ImplantBedMeasures& bed = measures.bed;
  if (!bed.found || bed.depth < 2 * kCrest) return;
  // Area and second moments of the bed's slices across the axis.
  const double step = bone.voxel() / 2, reach = 1.5 * plan.diameter / 2;
  double area = 0, ovality = 0;
  int slices = 0;
  for (double depth = kCrest; depth < std::min(bed.depth, plan.length) - 0.5e-3; depth += bone.voxel()) {
    double n = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
    for (double x = -reach; x <= reach; x += step) {
      for (double y = -reach; y <= reach; y += step) {
        if (x * x + y * y > reach * reach || bone.is_bone(plan.entry_W + depth * plan.axis_W + R * dvec3(x, y, 0)))
          continue;
        n += 1, sx += x, sy += y, sxx += x * x, syy += y * y, sxy += x * y;
      }
    }
    if (n < 16) continue;
    const double mx = sx / n, my = sy / n, a = sxx / n - mx * mx, b = syy / n - my * my, c = sxy / n - mx * my;
    const double mean = (a + b) / 2, apart = std::sqrt((a - b) * (a - b) / 4 + c * c);
    area += n * step * step;
    ovality += 4 * (std::sqrt(mean + apart) - std::sqrt(std::max(0.0, mean - apart)));
    ++slices;
  }
  if (slices > 0) {
    bed.diameter = 2 * std::sqrt(area / slices / kPi);
    bed.ovality = ovality / slices;
  }
  int open = 0, looks = 0, touching = 0, surface = 0;
  for (double depth = kCrest; depth < std::min(bed.depth, plan.length); depth += 2 * bone.voxel()) {
    for (int i = 0; i < kAround; ++i) {
      const dvec3 center = plan.entry_W + depth * plan.axis_W;
      ++looks;
      if (!bone.is_bone(center + R * around(i, std::max(bed.diameter / 2, plan.bed_diameter / 2) + kBehind))) ++open;
      ++surface;
      if (bone.is_bone(center + R * around(i, plan.diameter / 2 + bone.voxel()))) ++touching;
    }
  }
  if (task.neighbours.empty()) {
    bone.for_each([&](const dvec3& p_W) {
      if (!bone.is_tooth(p_W)) return;
      const dvec3 from = p_W - plan.entry_W;
      const double depth = std::clamp(glm::dot(from, plan.axis_W), 0.0, bed.depth);
      const double wall = std::max(bed.diameter, plan.bed_diameter) / 2;
      bed.neighbour_distance = std::min(bed.neighbour_distance, glm::length(from - depth * plan.axis_W) - wall);
    });
  }
  if (looks > 0) bed.perforated = static_cast<double>(open) / looks;
  if (surface > 0 && measures.placed) measures.bone_contact = static_cast<double>(touching) / surface;
}

}  // namespace typodont
