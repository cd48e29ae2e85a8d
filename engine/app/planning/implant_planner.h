// Planning of an implant: a proposal, the findings at a planned position, and sections through it as pictures. SI
// units, frame W. For one thread only.
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

/// A procedure file. It describes the implant and the phases of its placement (docs/scene_format.md).
struct ImplantProcedure {
  std::string path;   // path of the file as a scene states it, for example "implants/procedures/bone_level_48_12.json"
  std::string name;   // name that users see, for example "bone level 4.8 x 12 mm"
  double length = 0;  // m, length of the implant
  double diameter = 0;      // m, diameter of the implant's thread
  double bed_diameter = 0;  // m, diameter of the last drill, and so of the drilled hole
  double canal_margin = 0;  // m, smallest allowed distance to the nerve canal
};
/// Returns the shipped procedures and those in ~/Typodont/implants/procedures, sorted by name. Throws Error.
std::vector<ImplantProcedure> implant_procedures();
/// Reads a procedure. The file with this path is searched for in the same folders as the files of a scene at `place`.
/// Throws Error.
ImplantProcedure read_procedure(const std::string& path, const ScenePlace& place);

/// Returns the procedure of the scene's implant exercise; empty if the scene has none. Throws Error.
std::optional<ImplantProcedure> procedure_of(const Scene& scene);

/// Returns the class of the scene's bone, "I" to "IV"; empty if the scene's tissue is not of the kind "bone".
std::string bone_class_of(const Scene& scene);
/// Returns a copy of the scene with bone of another class. Throws Error if the scene's tissue is not of the kind
/// "bone", or if there is no class of this name.
Scene with_bone_class(const Scene& scene, const std::string& name);

/// Findings about an implant at its planned position.
struct PlanFindings {
  double in_bone = 0;  // fraction of the thread's surface that lies in bone
  /// m, highest point of the thread's surface that does not lie in bone; empty if the whole surface lies in bone
  std::optional<dvec3> leaves_at_W;
  double leaves_depth = 0;  // m, depth of the point leaves_at_W below the implant's upper end
  // m, distance between the surfaces of implant and canal; negative if the implant cuts the canal
  double canal_distance = std::numeric_limits<double>::infinity();
  // m, distance from the implant to the nearest tooth or to the nearest root that the scene lists, ±0.15 mm
  double tooth_distance = std::numeric_limits<double>::infinity();
  double mean_grey = 0;  // Hounsfield units, mean grey value of the bone around the thread
  bool fits() const { return !leaves_at_W; }
};

/// A rectangle in the tissue. A picture shows the section of the tissue in this rectangle.
struct SectionPlane {
  dvec3 center_W{0};
  /// unit vectors to the right and up in the picture, frame W; perpendicular to each other
  dvec3 right_W{1, 0, 0}, up_W{0, 0, 1};
  double width = 0, height = 0;  // m, width and height of the rectangle
  /// Returns the point (m, frame W) at a position of the picture. `fraction`: position as fractions of width and height
  /// from the top left corner.
  dvec3 at(const dvec2& fraction) const {
    return center_W + (fraction.x - 0.5) * width * right_W + (0.5 - fraction.y) * height * up_W;
  }
};
/// The three sections of a plan: across the arch, along the arch, and perpendicular to the implant.
using PlanPlanes = std::array<SectionPlane, 3>;

class ImplantPlanner {
 public:
  /// Loads the scene's tissue. Throws Error if the tissue has no grey values or contains no bone.
  explicit ImplantPlanner(const Scene& scene);

  const Scene& scene() const { return scene_; }
  const haptics::TissueVolume& volume() const { return volume_; }
  /// Returns the nerve canals. They are listed in the scene, or found in its tissue.
  const std::vector<NerveCanal>& canals() const { return canals_; }
  /// Returns the part of the nearest nerve canal that lies within 25 mm around the planned implant. It has no points if
  /// no canal is near.
  NerveCanal canal_near(const session::ImplantPlan& plan) const;

  /// If the scene has a plan, returns this plan with the procedure's implant. Otherwise proposes a vertical implant at
  /// the position with the largest fraction of its surface in bone. If several positions have this
  /// fraction, the one farthest from canals and teeth is chosen.
  session::ImplantPlan proposal(const ImplantProcedure& procedure) const;
  PlanFindings findings(const session::ImplantPlan& plan) const;

  /// Returns the planes of the three sections. The first two pass through the middle of the implant, the third near its
  /// upper end. `width`: m, width and height of each section.
  PlanPlanes planes(const session::ImplantPlan& plan, double width) const;
  /// Draws a section: the grey values, the outlines of implant and canals, and a red line at the depth at which the
  /// implant leaves the bone. `pixels`: width and height of the picture.
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
