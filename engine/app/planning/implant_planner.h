// Implant planning: proposal, findings, pictures of sections. SI units, frame W. Any thread may call const functions.
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

/// An implant with the phases of its procedure (docs/scene_format.md).
struct ImplantProcedure {
  std::string path;         // path as a scene states it: "implants/procedures/bone_level_48_12.json"
  std::string name;         // name for users: "bone level 4.8 x 12 mm"
  double length = 0;        // m, length of the implant
  double diameter = 0;      // m, diameter of the implant's thread
  double bed_diameter = 0;  // m, diameter of the last drill
  double canal_margin = 0;  // m, smallest allowed distance to the nerve canal
};
/// Shipped procedures and those in ~/Typodont/implants/procedures, by name. Throws Error.
std::vector<ImplantProcedure> implant_procedures();
/// Reads a procedure. Files that it names are searched in the folders of `place`, as for a scene. Throws Error.
ImplantProcedure read_procedure(const std::string& path, const ScenePlace& place);

/// The scene's procedure; empty if it has none. Throws Error.
std::optional<ImplantProcedure> procedure_of(const Scene& scene);

/// Class of the scene's bone, "I" to "IV"; empty if it has no tissue "bone".
std::string bone_class_of(const Scene& scene);
/// The scene with another class of bone. Throws Error if it has no tissue "bone", or if the class is unknown.
Scene with_bone_class(const Scene& scene, const std::string& name);

/// Findings about an implant at its planned position.
struct PlanFindings {
  double in_bone = 0;  // fraction of the thread's surface that lies in bone
  /// Highest point of the thread outside bone, m; empty: all of it is in bone.
  std::optional<dvec3> leaves_at_W;
  double leaves_depth = 0;  // m, depth of the point leaves_at_W below the implant's upper end
  // Distance between the surfaces of implant and canal, m; negative: the implant cuts the canal.
  double canal_distance = std::numeric_limits<double>::infinity();
  // Distance to the nearest tooth or root, m, ±0.15 mm.
  double tooth_distance = std::numeric_limits<double>::infinity();
  double mean_grey = 0;  // Hounsfield units, mean grey value of bone around the thread
  bool fits() const { return !leaves_at_W; }
};

/// The rectangle that a picture of a section shows.
struct SectionPlane {
  dvec3 center_W{0};
  /// Unit vectors that point right and up in the picture, perpendicular to each other, frame W.
  dvec3 right_W{1, 0, 0}, up_W{0, 0, 1};
  double width = 0, height = 0;  // m, width and height of the rectangle
  /// Point of the section, m, frame W. `fraction`: distance from its top left corner divided by width and height.
  dvec3 at(const dvec2& fraction) const {
    return center_W + (fraction.x - 0.5) * width * right_W + (0.5 - fraction.y) * height * up_W;
  }
};
/// Sections: across the arch, along the arch, and perpendicular to the implant.
using PlanPlanes = std::array<SectionPlane, 3>;

class ImplantPlanner {
 public:
  /// Throws Error if tissue lacks grey values or bone.
  explicit ImplantPlanner(const Scene& scene);

  const Scene& scene() const { return scene_; }
  const haptics::TissueVolume& volume() const { return volume_; }
  /// Nerve canal that the scene states; if it states none, the canals found in its tissue.
  const std::vector<NerveCanal>& canals() const { return canals_; }
  /// The nearest canal if it is closer than 25 mm to the implant; otherwise empty.
  NerveCanal canal_near(const session::ImplantPlan& plan) const;

  /// The scene's plan; if it has none, a proposal: the best position of a vertical implant. A large surface in bone
  /// has the largest weight; the distances to canals and teeth have small weights.
  session::ImplantPlan proposal(const ImplantProcedure& procedure) const;
  PlanFindings findings(const session::ImplantPlan& plan) const;

  /// Two sections through the implant's middle, and one near its upper end. `width`: m.
  PlanPlanes planes(const session::ImplantPlan& plan, double width) const;
  /// Picture of a section: grey values, outlines, and a red line where the implant leaves the bone. `pixels`: width and
  /// height of the picture.
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
