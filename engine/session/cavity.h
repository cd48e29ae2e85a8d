// Measures of a preparation: compares the removed (or added) tissue with the ideal (target shape). The functions use
// only dense distance fields and no state. The error of a measured length is not larger than the error of the fields.
// Lengths are in m.
#pragma once

#include <optional>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "engine/session/dense_field.h"

namespace typodont::session {

/// The tissue before the work, after the work and in its ideal form. All fields have the same voxel grid.
struct Preparation {
  VoxelFrame frame;            // position of the grid in frame W; sample (0,0,0) lies at the frame's origin
  DenseField before, after;    // distance fields before and after the work
  DenseField ideal;            // distance field of the ideal (target shape); empty if the task has no ideal
  std::vector<Tissue> tissue;  // tissue of each voxel before the work
  std::vector<bool> keep;      // marks voxels that must not be removed (a neighbouring tooth); may be empty
  // unit vector that points out of the opening, towards the user; a crown is placed from this side
  dvec3 axis_W{0, 0, 1};
};

struct Place {
  double depth = 0;  // m, depth of the deviation from the ideal (target shape); 0 if there is none
  dvec3 p_W{0};      // m, position of the deviation; valid if depth > 0
};

/// Measures of a preparation in SI units. A measure has no value if it does not apply to the preparation (for example,
/// if there is no floor or no pulp).
struct CavityMeasures {
  bool has_ideal = false;
  double wanted = 0;        // m³, volume that the ideal (target shape) removes or adds
  double done = 0;          // m³, the part of `wanted` that the trainee has removed or added
  double over_volume = 0;   // m³, volume of tissue that is missing although the ideal (target) keeps or adds it
  double under_volume = 0;  // m³, volume of tissue that remains although the ideal removes it, or of excess filling
  // places where the surface deviates most from the ideal (target shape): into the tissue (over) and out of it (under)
  Place over, under;
  // m, root mean square distance of the final surface from the ideal's surface. Only parts of the final surface that
  // were changed, or should have been changed, count. Closed pores do not count.
  std::optional<double> contour;

  double cut_area = 0;                   // m², area of the new surface
  std::optional<double> floor_depth;     // m, mean depth of the floor below the old surface, along axis_W
  std::optional<double> floor_flatness;  // m, root mean square distance of the floor from a plane
  std::optional<double> floor_tilt;      // rad, angle between the floor and the plane perpendicular to axis_W
  // Total occlusal convergence in rad: twice the mean inclination of the walls. Positive: the walls diverge towards the
  // opening.
  std::optional<double> taper;
  // m, mean depth of the walls, perpendicular to the old surface (for a crown: the axial reduction)
  std::optional<double> wall_depth;
  // m, smallest thickness of hard tissue behind the walls, without the walls' rim
  std::optional<double> wall_thickness;
  std::optional<double> isthmus;  // m, smallest width of the cavity across its longer axis, at half its depth
  // m, root mean square distance of the margin from the margin smoothed over 0.25 mm
  std::optional<double> margin_roughness;
  // m, smallest distance from the new surface to the pulp; not more than kPulpReach
  std::optional<double> pulp_distance;
  std::optional<double> pulp_exposed;  // m², area of exposed pulp; no value if there is no pulp
  struct Cup {
    dvec3 center_W{0};  // m, frame W, centre of the sphere that is fitted to a reamed socket
    double radius = 0;  // m, radius of the sphere that is fitted to a reamed socket
    dvec3 axis_W{0};    // unit vector out of the opening, the mean normal of the new surface
  };
  std::optional<Cup> cup;            // a sphere fitted to the new surface, for a socket that was reamed
  std::optional<double> cup_offset;  // m, distance between the centres of `cup` and of the ideal's cup
  std::optional<double> cup_tilt;    // rad, angle between the axes of `cup` and of the ideal's cup
  // Removed volume, in m³, of tissue that must not be removed. No value if there is no such tissue.
  std::optional<double> kept_removed;
};

/// Largest distance to the pulp, in m, that is measured.
inline constexpr double kPulpReach = 2e-3;

CavityMeasures measure_cavity(const Preparation& preparation);

/// The measures of the result, and the measures of the ideal (target shape), which a perfect hand would achieve.
struct CavityAndIdeal {
  CavityMeasures result;
  std::optional<CavityMeasures> ideal;  // no value if the task has no ideal
};
/// Data that depend only on the tissue before the work and on the ideal, and not on the result. Their computation takes
/// long, so all results of the same task share them.
struct CavityReference {
  TrueDistances before;
  std::optional<TrueDistances> ideal;      // no value if the task has no ideal
  std::vector<bool> pulp;                  // true for each voxel of pulp
  std::vector<std::size_t> to_pulp;        // for each voxel: index of the nearest pulp voxel; empty if there is no pulp
  std::optional<CavityMeasures> measures;  // of the ideal; no value if the task has no ideal
};
CavityReference cavity_reference(const Preparation& preparation);
/// `reference`: of a preparation with the same grid, the same tissue before the work and the same ideal.
CavityAndIdeal measure_against_ideal(const Preparation& preparation, const CavityReference& reference);

}  // namespace typodont::session
