// Implant planning: proposal, findings, sections as pictures. SI, W. One thread.
#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/planning/planning_tissue.h"
#include "engine/app/scene.h"
#include "engine/render/picture.h"
#include "engine/session/implant.h"

namespace typodont {

using glm::dvec2;

/// The implant and its phases (docs/scene_format.md).
struct ImplantProcedure {
  std::string path;         // as a scene names it: "implants/procedures/bone_level_48_12.json"
  std::string name;         // for users: "bone level 4.8 x 12 mm"
  double length = 0;        // m, length of the implant
  double diameter = 0;      // m, diameter of the implant's thread
  double bed_diameter = 0;  // m, of the last drill
  double canal_margin = 0;  // m, smallest allowed distance to the nerve canal
};
/// Shipped ones and those of ~/Typodont/implants/procedures, by name. Throws Error.
std::vector<ImplantProcedure> implant_procedures();
/// Searched like the files of a scene at `place`. Throws Error.
ImplantProcedure read_procedure(const std::string& path, const ScenePlace& place);

/// Empty if the scene has none. Throws Error.
std::optional<ImplantProcedure> procedure_of(const Scene& scene);

/// "I" to "IV"; empty: no tissue "bone".
std::string bone_class_of(const Scene& scene);
/// Throws Error without tissue "bone", or for an unknown class.
Scene with_bone_class(const Scene& scene, const std::string& name);

/// Findings about an implant at its planned position.
struct PlanFindings {
  double in_bone = 0;  // fraction of the thread's surface that lies in bone
  /// m, highest point of the thread outside bone; empty: all in bone
  std::optional<dvec3> leaves_at_W;
  double leaves_depth = 0;  // m, depth of the point leaves_at_W below the implant's upper end
  // m between surfaces; negative: cuts the canal
  double canal_distance = std::numeric_limits<double>::infinity();
  // m to the nearest tooth or listed root, ±0.15 mm
  double tooth_distance = std::numeric_limits<double>::infinity();
  double mean_grey = 0;  // Hounsfield units, mean grey value of the bone around the thread
  bool fits() const { return !leaves_at_W; }
};

/// Rectangle of a section.
struct SectionPlane {
  dvec3 center_W{0};
  /// unit vectors of the picture, perpendicular, W
  dvec3 right_W{1, 0, 0}, up_W{0, 0, 1};
  double width = 0, height = 0;  // m, width and height of the rectangle
  /// m, W. `fraction`: of width and height from the top left.
  dvec3 at(const dvec2& fraction) const {
    return center_W + (fraction.x - 0.5) * width * right_W + (0.5 - fraction.y) * height * up_W;
  }
};
/// Across the arch, along it, perpendicular to the implant.
using PlanPlanes = std::array<SectionPlane, 3>;

class ImplantPlanner {
 public:
  /// Throws Error without grey values or bone.
  explicit ImplantPlanner(const Scene& scene);

  const Scene& scene() const { return scene_; }
  const haptics::TissueVolume& volume() const { return volume_; }
  /// Of the scene, or found in its tissue.
  const std::vector<NerveCanal>& canals() const { return canals_; }
  /// The nearest one within 25 mm of the implant; empty: none.
  NerveCanal canal_near(const session::ImplantPlan& plan) const;

  /// The scene's plan, or a vertical implant with the most surface in bone, then farthest from canals and teeth.
  session::ImplantPlan proposal(const ImplantProcedure& procedure) const;
  PlanFindings findings(const session::ImplantPlan& plan) const;

  /// Two through the implant's middle, one near its upper end. `width`: m.
  PlanPlanes planes(const session::ImplantPlan& plan, double width) const;
  /// Grey values, outlines, and a red line where the implant leaves bone. `pixels`: of the picture.
  render::Picture picture(const SectionPlane& plane, const session::ImplantPlan& plan, int pixels) const;

 private:
  dvec3 along_arch(const session::ImplantPlan& plan) const;

  Scene scene_;
  haptics::TissueVolume volume_;
  PlanningTissue tissue_;
  std::vector<NerveCanal> canals_;
  std::vector<session::NeighbourRoot> roots_;
};

}  // namespace typodont
