// Compares removed or added tissue with the ideal shape, from dense distance fields. Functions without state. Lengths
// in m, as exact as the fields.
#pragma once

#include <optional>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "engine/session/dense_field.h"

namespace typodont::session {

/// Tissue before and after the work, and the ideal result, on one grid.
struct Preparation {
  VoxelFrame frame;            // sample (0,0,0) is at the frame's origin
  DenseField before, after;    // distance fields before and after the work
  DenseField ideal;            // distance field of the target shape; empty if the task has none
  std::vector<Tissue> tissue;  // tissue of each voxel before the work
  std::vector<bool> keep;      // voxels that must not be removed, such as a neighbouring tooth; may be empty
  // Unit vector out of the cavity's opening. For a crown: the direction from which the crown is placed.
  dvec3 axis_W{0, 0, 1};
  bool contour = false;  // the target shape is the tooth's own surface, for example under calculus or around a filling
};

struct Place {
  double depth = 0;  // m, distance from the target shape; 0: no deviation
  dvec3 p_W{0};      // m, frame W, the point at which `depth` was measured; valid if depth > 0
};

/// Measures of a cavity in SI units. A measure is empty if it does not apply, for example without a floor.
struct CavityMeasures {
  bool has_ideal = false;
  double wanted = 0;        // m³, volume that the ideal shape removes or adds
  double done = 0;          // m³, part of `wanted` that is done
  double over_volume = 0;   // m³, tissue that is missing although the ideal shape has it
  double under_volume = 0;  // m³, tissue that is left although the ideal shape removes it, or excess filling
  // Points farthest from the ideal shape: cut too deep (over), and tissue left (under).
  Place over, under;
  // Distance of the surface from the target shape, root mean square, m. Only where the surface changed or should have
  // changed, and without closed pores.
  std::optional<double> contour;

  double cut_area = 0;                   // m², area of the new surface
  std::optional<double> floor_depth;     // m, mean depth below the surface before the work, along axis_W
  std::optional<double> floor_flatness;  // m, root mean square distance of the floor from a plane
  std::optional<double> floor_tilt;      // rad, the floor's angle to the plane perpendicular to axis_W
  // Total occlusal convergence: twice the mean inclination of the walls, rad. Positive: the cavity opens outwards.
  std::optional<double> taper;
  // Mean distance of the walls from the surface before the work, along their normal, m. For a crown: axial reduction.
  std::optional<double> wall_depth;
  // Smallest thickness of hard tissue behind the walls, m. The cavity's rim is left out.
  std::optional<double> wall_thickness;
  std::optional<dvec3> thinnest_W;  // m, frame W, place of the smallest thickness
  std::optional<double> isthmus;    // m, smallest width across the cavity's longer axis, at half depth
  // Distance of the margin from its own smoothed curve (Gaussian of 0.25 mm), root mean square, m.
  std::optional<double> margin_roughness;
  // Smallest distance from new surface to pulp, m; at most kPulpReach.
  std::optional<double> pulp_distance;
  std::optional<dvec3> nearest_pulp_W;  // m, frame W, point of the new surface nearest to the pulp
  std::optional<double> pulp_exposed;   // m², exposed area of the pulp; empty: no pulp
  struct Cup {
    dvec3 center_W{0};  // m, frame W, centre of the sphere fitted to a reamed socket
    double radius = 0;  // m, radius of the sphere fitted to a reamed socket
    dvec3 axis_W{0};    // unit vector out of the opening: the surface's mean normal
  };
  std::optional<Cup> cup;            // sphere fitted to a reamed socket (hollow half of a joint)
  std::optional<double> cup_offset;  // m, distance of the cup's centre from the ideal shape's
  std::optional<double> cup_tilt;    // rad, angle between the cup's axis and the ideal shape's
  // Removed tissue that had to stay, m³. Empty: no tissue had to stay.
  std::optional<double> kept_removed;
};

/// Largest distance from the pulp that is measured, m.
inline constexpr double kPulpReach = 2e-3;

/// Measures of the user's result, and for comparison those of the target shape.
struct CavityAndIdeal {
  CavityMeasures result;
  std::optional<CavityMeasures> ideal;  // no value if the task has no target shape
};
/// Data that depends only on the ideal shape and the tissue before the work, so one computation (slow) serves all
/// results of a task.
struct CavityReference {
  TrueDistances before;
  std::optional<TrueDistances> ideal;      // no value if the task has no target shape
  std::vector<bool> pulp;                  // true for each voxel of pulp
  std::vector<std::size_t> to_pulp;        // index of the pulp voxel nearest to each voxel; empty if there is no pulp
  std::optional<CavityMeasures> measures;  // measures of the target shape; empty: none
};
CavityReference cavity_reference(const Preparation& preparation);
/// `reference` must be computed from the same grid, tissue before the work and target shape.
CavityAndIdeal measure_against_ideal(const Preparation& preparation, const CavityReference& reference);

}  // namespace typodont::session
