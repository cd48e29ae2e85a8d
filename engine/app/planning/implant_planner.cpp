#include "engine/app/planning/implant_planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/app/assets.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene/implant_scene.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/units.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

constexpr double kNearTooth = 10e-3;    // m, teeth farther from the implant than this are ignored
constexpr double kRootMargin = 1.5e-3;  // m, smallest distance between a proposed implant and a tooth
// Distance between the points at which labels of teeth are searched around an implant, m.
constexpr double kToothStep = 0.25e-3;
// Points of a nerve canal farther from the implant than this are ignored, m.
constexpr double kCanalReach = 25e-3;
// Distance between neighbouring positions of the implant that the proposal tries, m.
constexpr double kEntrySpacing = 1e-3;
constexpr double kBelowCrest = 0.5e-3;  // m, depth of a proposed implant's upper end below the ridge's top
constexpr double kRidge = 10e-3;        // m, radius of the region of bone from which the arch's direction is computed
constexpr double kOutline = 0.8;        // pixels, half the width of the outlines in a section's picture

/// Distance between canal and implant, m.
double canal_distance(const NerveCanal& canal, const session::ImplantPlan& plan) {
  return plan.cylinder().distance(canal.path_W) - canal.radius;
}

/// Loads the tissue without checking the scene's plan, because the user will replace an invalid plan.
haptics::TissueVolume tissue_of(Scene scene) {
  scene.implant.reset();
  haptics::TissueVolume volume = load_tissue(scene);
  require_greys(volume, scene.file);
  return volume;
}

}  // namespace

ImplantProcedure read_procedure(const std::string& path, const ScenePlace& place) {
  const Json json = Json::load(find_file(path, place));
  const Json template_json = Json::load(implant_exercise_file());
  const fs::path set = find_file(template_json["tool_set"], place);
  const haptics::Tool implant = load_set_tool(set, json["implant"]);
  return {path,
          json["name"].string(),
          implant.length,
          implant.diameter,
          json["bed_diameter_mm"].number(0.5, 10) * kMillimetre,
          json["limits"]["canal_mm"].number(0, 10) * kMillimetre};
}

std::vector<ImplantProcedure> implant_procedures() {
  std::vector<ImplantProcedure> procedures;
  const std::string folder = "implants/procedures";
  for (const bool own : {false, true}) {
    const fs::path root = own ? user_folder() : assets_folder();
    for (const fs::path& file : files_in(root / folder, ".json"))
      procedures.push_back(read_procedure(own ? file.string() : folder + "/" + file.filename().string(), {}));
  }
  std::sort(procedures.begin(), procedures.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return procedures;
}

std::optional<ImplantProcedure> procedure_of(const Scene& scene) {
  const auto implant = Json::parse(scene.text, scene.file.string()).find("implant");
  if (!implant) return std::nullopt;
  return read_procedure((*implant)["procedure"].string(), scene.place);
}

std::string bone_class_of(const Scene& scene) {
  const auto bone = scene.tissue->find("bone");
  return bone ? (*bone)["class"].string() : "";
}

Scene with_bone_class(const Scene& scene, const std::string& name) {
  if (bone_class_of(scene).empty()) {
    throw Error(scene.file.string(), "tissue", "tissue that is not a \"bone\"",
                "a scene with {\"bone\": …}; a scan has the bone that it has");
  }
  nlohmann::ordered_json text = nlohmann::ordered_json::parse(scene.text);
  text["tissue"]["bone"]["class"] = name;
  return parse_scene(Json::parse(text.dump(), scene.file.string(), Json::Lines::kUnknown), scene.file, scene.place);
}

ImplantPlanner::ImplantPlanner(const Scene& scene) : scene_(scene), volume_(tissue_of(scene)), tissue_(volume_) {
  if (scene.implant && !scene.implant->canal_W.empty())
    canals_.push_back({scene.implant->canal_W, scene.implant->canal_radius});
  else
    canals_ = tissue_.canals();
  if (scene.implant) roots_ = scene.implant->neighbours;
}

NerveCanal ImplantPlanner::canal_near(const session::ImplantPlan& plan) const {
  const NerveCanal* nearest = nullptr;
  double best = std::numeric_limits<double>::infinity();
  for (const NerveCanal& canal : canals_) {
    const double distance = canal_distance(canal, plan);
    if (distance < best) best = distance, nearest = &canal;
  }
  NerveCanal near;
  if (!nearest) return near;
  near.radius = nearest->radius;
  for (const dvec3& p : nearest->path_W)
    if (plan.cylinder().distance(p) < kCanalReach) near.path_W.push_back(p);
  if (near.path_W.size() < 2) near = {};
  return near;
}

PlanFindings ImplantPlanner::findings(const session::ImplantPlan& plan) const {
  PlanFindings found;
  int points = 0, in_bone = 0;
  for_thread_surface(plan, [&](const dvec3& p_W, double depth) {
    ++points;
    if (tissue_.is_bone(p_W)) {
      ++in_bone;
      found.mean_grey += tissue_.grey(p_W);
    } else if (!found.leaves_at_W) {
      found.leaves_at_W = p_W;
      found.leaves_depth = depth;
    }
    return true;
  });
  if (in_bone > 0) found.mean_grey /= in_bone;
  if (points > 0) found.in_bone = static_cast<double>(in_bone) / points;
  for (const NerveCanal& canal : canals_)
    found.canal_distance = std::min(found.canal_distance, canal_distance(canal, plan));
  const session::ImplantCylinder implant = plan.cylinder();
  for (const session::NeighbourRoot& root : roots_)
    found.tooth_distance =
        std::min(found.tooth_distance, implant.distance(std::array{root.a_W, root.b_W}) - root.radius);
  const dvec3 a = plan.entry_W, b = plan.apex_W(), reach(plan.diameter / 2 + kNearTooth);
  const dvec3 lo = glm::max(glm::min(a, b) - reach, tissue_.lo_W()),
              hi = glm::min(glm::max(a, b) + reach, tissue_.hi_W());
  const double step = std::max(tissue_.spacing(), kToothStep);
  for (double x = lo.x; x <= hi.x; x += step)
    for (double y = lo.y; y <= hi.y; y += step)
      for (double z = lo.z; z <= hi.z; z += step)
        if (const dvec3 p_W(x, y, z); tissue_.is_tooth(p_W))
          found.tooth_distance = std::min(found.tooth_distance, implant.distance(p_W));
  return found;
}

session::ImplantPlan ImplantPlanner::proposal(const ImplantProcedure& procedure) const {
  session::ImplantPlan plan;
  if (scene_.implant) plan = scene_.implant->plan;
  plan.length = procedure.length;
  plan.diameter = procedure.diameter;
  plan.bed_diameter = procedure.bed_diameter;
  if (scene_.implant) return plan;
  const dvec3 lo = tissue_.lo_W(), hi = tissue_.hi_W();
  double best = -1;
  session::ImplantPlan proposed = plan;
  proposed.entry_W = 0.5 * (lo + hi);
  for (double x = lo.x; x <= hi.x; x += kEntrySpacing) {
    for (double y = lo.y; y <= hi.y; y += kEntrySpacing) {
      double z = hi.z;
      while (z > lo.z && tissue_.at({x, y, z}) == Tissue::kAir) z -= tissue_.spacing();
      if (!tissue_.is_bone({x, y, z})) continue;
      plan.entry_W = {x, y, z - kBelowCrest};
      int points = 0, in_bone = 0;
      for_thread_surface(plan, [&](const dvec3& p_W, double) {
        ++points;
        in_bone += tissue_.is_bone(p_W);
        return true;
      });
      double clearance = std::numeric_limits<double>::infinity();
      for (const NerveCanal& canal : canals_) clearance = std::min(clearance, canal_distance(canal, plan));
      bool near_tooth = false;
      session::ImplantPlan wider = plan;
      wider.diameter += 2 * kRootMargin;
      for_thread_surface(wider, [&](const dvec3& p_W, double) {
        near_tooth = tissue_.is_tooth(p_W);
        return !near_tooth;
      });
      // Value of this position: part of the surface in bone; with less weight: canal, teeth, distance from middle.
      const double margin = std::clamp(clearance / procedure.canal_margin, 0.0, 1.0);
      const double middle = glm::length(dvec2(x, y) - 0.5 * dvec2(lo + hi)) / glm::length(dvec2(hi - lo));
      const double value =
          static_cast<double>(in_bone) / points + 0.1 * margin - (near_tooth ? 0.1 : 0) - 0.01 * middle;
      if (value > best) best = value, proposed = plan;
    }
  }
  return proposed;
}

dvec3 ImplantPlanner::along_arch(const session::ImplantPlan& plan) const {
  const dquat R = rotation_between({0, 0, -1}, plan.axis_W);
  const dvec3 u = R * dvec3(1, 0, 0), v = R * dvec3(0, 1, 0), middle = plan.entry_W + 0.3 * plan.length * plan.axis_W;
  double n = 0, su = 0, sv = 0, uu = 0, vv = 0, uv = 0;
  const double step = std::max(tissue_.spacing(), 0.3e-3);
  for (double a = -kRidge; a <= kRidge; a += step) {
    for (double b = -kRidge; b <= kRidge; b += step) {
      if (a * a + b * b > kRidge * kRidge || tissue_.at(middle + a * u + b * v) == Tissue::kAir) continue;
      n += 1, su += a, sv += b, uu += a * a, vv += b * b, uv += a * b;
    }
  }
  if (n < 3) return u;
  const double suu = uu - su * su / n, svv = vv - sv * sv / n, suv = uv - su * sv / n;
  // Angle from the vector u to the longest axis of the bone's cross-section, rad.
  const double angle = 0.5 * std::atan2(2 * suv, suu - svv);
  const dvec3 along = std::cos(angle) * u + std::sin(angle) * v;
  return along.x < 0 ? -along : along;
}

PlanPlanes ImplantPlanner::planes(const session::ImplantPlan& plan, double width) const {
  const dvec3 up = -plan.axis_W, along = along_arch(plan), across = glm::cross(up, along);
  const dvec3 middle = plan.entry_W + 0.5 * plan.length * plan.axis_W;
  // The third section lies half a millimetre below the implant's upper end, where bone surrounds the implant.
  const dvec3 level = plan.entry_W + kBelowCrest * plan.axis_W;
  return {SectionPlane{middle, across, up, width, width}, SectionPlane{middle, along, up, width, width},
          SectionPlane{level, along, across, width, width}};
}

render::Picture ImplantPlanner::picture(const SectionPlane& plane, const session::ImplantPlan& plan, int pixels) const {
  constexpr double kBrightest = 2500;  // Hounsfield units; voxels from this value on are drawn white
  const glm::dvec3 kImplant(70, 200, 235), kCanal(240, 150, 50), kLeaves(235, 60, 50);
  // Selects the canals' parts that the plane may intersect.
  std::vector<NerveCanal> near;
  const dvec3 normal = glm::cross(plane.right_W, plane.up_W);
  for (const NerveCanal& canal : canals_) {
    for (std::size_t i = 0; i + 1 < canal.path_W.size(); ++i) {
      const double a = glm::dot(canal.path_W[i] - plane.center_W, normal);
      const double b = glm::dot(canal.path_W[i + 1] - plane.center_W, normal);
      const double reach = canal.radius + kOutline * plane.width / pixels;
      if (std::min(a, b) < reach && std::max(a, b) > -reach)
        near.push_back({{canal.path_W[i], canal.path_W[i + 1]}, canal.radius});
    }
  }
  const session::ImplantCylinder cylinder = plan.cylinder();
  const double pixel = plane.width / pixels, half_line = kOutline * pixel;
  render::Picture picture{{pixels, pixels}, {}};
  picture.rgba.reserve(4 * static_cast<std::size_t>(pixels) * static_cast<std::size_t>(pixels));
  for (int y = 0; y < pixels; ++y) {
    for (int x = 0; x < pixels; ++x) {
      const dvec3 p_W = plane.at((dvec2(x, y) + 0.5) / static_cast<double>(pixels));
      const double grey = tissue_.grey(p_W);
      dvec3 color(grey < -500 ? 24 : 45 + 205 * std::sqrt(std::clamp(grey / kBrightest, 0.0, 1.0)));
      double canal = std::numeric_limits<double>::infinity();
      for (const NerveCanal& segment : near) canal = std::min(canal, segment.distance(p_W));
      if (canal < 0) color = glm::mix(color, kCanal, 0.6);
      if (std::abs(canal) < half_line) color = kCanal;
      const double implant = cylinder.distance(p_W);
      if (implant < 0) color = glm::mix(color, kImplant, 0.2);
      if (std::abs(implant) < half_line) {
        const double depth = glm::dot(p_W - plan.entry_W, plan.axis_W);
        color = depth > kCrest && !tissue_.is_bone(p_W) ? kLeaves : kImplant;
      }
      for (int c = 0; c < 3; ++c) picture.rgba.push_back(static_cast<std::uint8_t>(std::lround(color[c])));
      picture.rgba.push_back(255);
    }
  }
  return picture;
}

}  // namespace typodont
