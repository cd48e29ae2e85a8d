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
#include "engine/base/folder.h"
#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/described.h"
#include "haptics/tool.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

// The wall of the drilled hole counts as open where no bone lies at this depth behind the wall, m.
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
    for_each_voxel(box_.field.size, [&](const glm::ivec3& p) { visit(frame_.to_world(dvec3(lo_ + p))); });
  }
  double voxel() const { return frame_.voxel; }

 private:
  /// Tissue of the nearest voxel; air outside of the box.
  Tissue tissue_at(const dvec3& p_W) const {
    const glm::ivec3 p = glm::ivec3(glm::round(frame_.to_voxels(p_W))) - lo_;
    if (!in_grid(p, box_.field.size)) return Tissue::kAir;
    const std::size_t i = box_.field.at(p.x, p.y, p.z);
    return box_.field.distance[i] < 0 ? box_.tissue[i] : Tissue::kAir;
  }
  // Frame of the whole volume, so that nearest voxels are the same as in the volume.
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
  for (const fs::path& file : files_in(folder, ".json")) names.push_back(file.stem().string());
  if (std::find(names.begin(), names.end(), wanted) == names.end()) {
    name.fail(fmt::format("\"{}\", which is not in the set {}", wanted, folder.filename().string()),
              fmt::format("one of: {}", fmt::join(names, ", ")));
  }
  haptics::Tool tool = haptics::read_tool(Json::load(folder / (wanted + ".json")));
  tool.name = wanted;
  return tool;
}

std::uint32_t tool_named(const Json& name, std::span<const haptics::Tool> tools) {
  const auto found = std::ranges::find(tools, name.string(), &haptics::Tool::name);
  if (found == tools.end()) {
    std::vector<std::string> names;
    for (const haptics::Tool& tool : tools) names.push_back(tool.name);
    name.fail(fmt::format("\"{}\", which is not among the scene's tools", name.string()),
              fmt::format("one of: {}", fmt::join(names, ", ")));
  }
  return static_cast<std::uint32_t>(found - tools.begin());
}

namespace {

void describe_plan(Keys& keys, session::ImplantPlan& plan) {
  keys(must("entry_mm"), plan.entry_W, kMillimetre, "middle of the implant's platform");
  keys(must("axis"), plan.axis_W, haptics::read_direction_into_bone, "direction of the implant into the bone");
}

void describe_phase(Keys& keys, session::ImplantPhase& phase, std::span<const haptics::Tool> tools) {
  session::describe_text(keys, must("name"), phase.name, "name of the phase");
  keys(must("deed"), phase.deed, session::kImplantActions, "kind of action");
  if (const auto name = keys(must("tool"), kName, "the instrument, a tool of the scene with the block `implant`")) {
    phase.tool = tool_named(*name, tools);
    const auto& tool = tools[phase.tool].implant;
    if (!tool) name->fail("a tool with an \"implant\" block");
    phase.speed = tool->speed;
    phase.irrigated = tool->irrigated;
  }
  keys("depth_mm", phase.depth, {-5, 30, kMillimetre}, "depth that the tool must reach");
  keys("volume_mm3", phase.volume, {0, 1000, kCubicMillimetre}, "volume to remove in `smooth` and `mark`");
}

void describe_limits(Keys& keys, session::ImplantTask& task) {
  keys(must("force_N"), task.max_force, {0.1, 200}, "largest force");
  keys(must("angle_deg"), task.max_angle, {0.1, 45, kDegree}, "largest angle to the planned axis");
  keys(must("too_deep_mm"), task.depth_tolerance, {0.05, 5, kMillimetre}, "largest depth beyond the planned depth");
  keys(must("canal_mm"), task.canal_clearance, {0, 10, kMillimetre}, "smallest distance to the nerve canal");
  keys.ignore("source");
}

}  // namespace

void describe_procedure(Keys& keys, session::ImplantTask& task, std::span<const haptics::Tool> tools) {
  keys("name", kText, "name of the procedure");
  if (const auto name = keys(must("implant"), kName, "the tool of the kind `implant` that is placed")) {
    const haptics::Tool& implant = tools[tool_named(*name, tools)];
    if (!implant.implant || implant.implant->kind != haptics::ImplantToolKind::kImplant)
      name->fail("a tool of the kind \"implant\"");
    task.plan.length = implant.length;
    task.plan.diameter = implant.diameter;
  }
  keys(must("bed_diameter_mm"), task.plan.bed_diameter, {0.5, 10, kMillimetre}, "diameter of the implant bed");
  keys(
      must("phases"), task.phases, [&](Keys& of, session::ImplantPhase& phase) { describe_phase(of, phase, tools); },
      "the steps of the procedure, in order");
  if (keys.json() && task.phases.empty()) (*keys.json())["phases"].fail("at least one phase");
  keys(must("limits"), task, describe_limits, "limits for messages");
  keys.ignore("source");
}

void describe_implant(Keys& keys, session::ImplantTask& task, const NerveCanal& bones,
                      std::span<const haptics::Tool> tools, const ScenePlace& place) {
  if (const auto file = keys(must("procedure"), kFile, "for example `implants/procedures/bone_level_48_12.json`")) {
    read_keys(Json::load(find_file(*file, place)), [&](Keys& of) { describe_procedure(of, task, tools); });
  }
  keys(must("plan"), task.plan, describe_plan, "planned position of the implant");
  const auto root = [](Keys& of, session::NeighbourRoot& of_root) {
    of(must("a_mm"), of_root.a_W, kMillimetre, "one end of its axis");
    of(must("b_mm"), of_root.b_W, kMillimetre, "the other end");
    of(must("radius_mm"), of_root.radius, {0.1, 10, kMillimetre}, "radius");
  };
  keys("neighbours", task.neighbours, root,
       "roots of the neighbouring teeth. Without this key, the score `neighbour_distance_mm` is the distance to the "
       "nearest enamel or dentin of the tissue");
  NerveCanal canal = bones;
  if (keys.json() && keys.json()->has("canal") && !bones.path_W.empty())
    (*keys.json())["canal"].fail("a canal here and one in the tissue's bone", "one of them");
  keys("canal", canal, describe_canal,
       "the nerve canal of a tissue that is read from a volume. It is an error if the tissue has a canal in "
       "[`bone`](#bone)");
  task.canal_W = canal.path_W;
  task.canal_radius = canal.radius;
  if (!keys.json()) return;
  for (const haptics::Tool& tool : tools) {
    task.tip.push_back(tool.half());
    task.radius.push_back(tool.radius());
  }
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
  // Computes area and second moments of the drilled hole in slices perpendicular to the axis.
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
