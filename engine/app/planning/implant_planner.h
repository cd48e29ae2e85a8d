// Planning an implant: a proposal, the findings at a planned position, and sections through it as pictures. SI, frame
// W. One thread.
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

/// A procedure file: the implant and its phases (docs/interface.md).
struct ImplantProcedure {
  std::string path;         // path as in a scene, e.g. "implants/procedures/bone_level_48_12.json"
  std::string name;         // name for users, e.g. "bone level 4.8 x 12 mm"
  double length = 0;        // m, length of the implant
  double diameter = 0;      // m, diameter of the implant's thread
  double bed_diameter = 0;  // m, diameter of the last drill
  double canal_margin = 0;  // m, lower limit of the distance to the nerve canal
};
/// The shipped procedures and those in ~/Typodont/implants/procedures, sorted by name. Throws Error.
std::vector<ImplantProcedure> implant_procedures();
/// Reads a procedure. `path`: path as in a scene at `place`. Throws Error.
ImplantProcedure read_procedure(const std::string& path, const ScenePlace& place);

/// The procedure of the scene's implant exercise; no value if the scene has none. Throws Error.
std::optional<ImplantProcedure> procedure_of(const Scene& scene);

/// Class of the scene's bone, "I" to "IV"; empty if the scene's tissue is not a "bone".
std::string bone_class_of(const Scene& scene);
/// Returns the scene with bone of another class. Throws Error if its tissue is not a "bone", or if the class does not
/// exist.
Scene with_bone_class(const Scene& scene, const std::string& name);

/// Findings about an implant at its planned position.
struct PlanFindings {
  double in_bone = 0;                // fraction of the thread's surface that lies in bone
  std::optional<dvec3> leaves_at_W;  // m, the highest point of the thread's surface that does not lie in bone
  double leaves_depth = 0;           // m, depth of that point below the platform
  // m, distance between the walls of implant and canal; negative: the implant cuts the canal
  double canal_distance = std::numeric_limits<double>::infinity();
  // m, distance to the nearest tooth or listed root, ±0.15 mm
  double tooth_distance = std::numeric_limits<double>::infinity();
  double mean_grey = 0;  // Hounsfield units, mean of the bone around the thread
  bool fits() const { return !leaves_at_W; }
};

/// A rectangle in the tissue that is shown as a picture.
struct SectionPlane {
  dvec3 center_W{0};
  dvec3 right_W{1, 0, 0}, up_W{0, 0, 1};   // unit vectors, perpendicular to each other
  double width = 0, height = 0;            // m
  dvec3 at(const dvec2& fraction) const {  // fractions of width and height from the top left corner
    return center_W + (fraction.x - 0.5) * width * right_W + (0.5 - fraction.y) * height * up_W;
  }
};
/// Three sections: across the arch, along the arch, and perpendicular to the implant.
using PlanPlanes = std::array<SectionPlane, 3>;

class ImplantPlanner {
 public:
  /// Loads the scene's tissue. Throws Error if the tissue has no grey values, or no bone.
  explicit ImplantPlanner(const Scene& scene);

  const Scene& scene() const { return scene_; }
  const haptics::TissueVolume& volume() const { return volume_; }
  /// The canals: the scene's canal, or those found in its tissue.
  const std::vector<NerveCanal>& canals() const { return canals_; }
  /// The canal nearest to the plan, limited to 25 mm around the implant; without points if no canal is near.
  NerveCanal canal_near(const session::ImplantPlan& plan) const;

  /// The scene's own plan with this procedure's implant. If the scene has no plan: a vertical implant at the position
  /// with the largest fraction in bone, and among equal ones with the largest distance to canals and teeth.
  session::ImplantPlan proposal(const ImplantProcedure& procedure) const;
  PlanFindings findings(const session::ImplantPlan& plan) const;

  /// The planes of the sections. The first two pass through the middle of the implant, the third through its
  /// platform. `width`: m, width and height of each section.
  PlanPlanes planes(const session::ImplantPlan& plan, double width) const;
  /// The picture of a section: the grey values on the plane, the outlines of implant and canals, and, in red, the
  /// depth at which the implant leaves the bone. `pixels`: width and height of the picture.
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
