// Geometry of a preparation: compares the removed (or added) tissue with the ideal. Pure functions of dense fields;
// they add no error to that of the fields, and use neither haptics nor the surface mesher. Lengths in metres.
#pragma once

#include <optional>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "engine/session/dense_field.h"

namespace typodont::session {

/// One piece of tissue before the work, after the work and in its ideal form. All fields use the same voxels.
struct Preparation {
  VoxelFrame frame;            // sample (0,0,0) lies at the frame's origin
  DenseField before, after;    // distance fields at the start and at the end
  DenseField ideal;            // the ideal result; empty: the task has no ideal
  std::vector<Tissue> tissue;  // labels at the start
  std::vector<bool> keep;      // voxels that must not be removed (a neighbouring tooth); may be empty
  dvec3 axis_W{0, 0, 1};  // unit vector out of the opening; from this side the bur approaches, and a crown is placed
};

struct Place {
  double depth = 0;  // m
  dvec3 p_W{0};      // valid if depth > 0
};

/// Measures of a preparation in SI units. A measure that does not apply to this preparation (no floor, no pulp …) is
/// absent.
struct CavityMeasures {
  bool has_ideal = false;
  double wanted = 0;        // m³, volume that the ideal removes or adds
  double done = 0;          // m³, completed part of `wanted`
  double over_volume = 0;   // m³, volume of missing tissue that the ideal keeps (or adds)
  double under_volume = 0;  // m³, volume of remaining tissue that the ideal removes, or of excess filling
  Place over, under;        // largest deviations of the surface: into the tissue (over) and out of it (under)
  // m rms, distance from the ideal's surface over all parts that changed or should have changed; closed pores do not
  // count
  std::optional<double> contour;

  double cut_area = 0;                   // m², area of new surface
  std::optional<double> floor_depth;     // m, mean depth along the axis below the old surface
  std::optional<double> floor_flatness;  // m rms, distance from the floor's plane
  std::optional<double> floor_tilt;      // rad, angle between the floor's plane and the plane across the axis
  // rad, total occlusal convergence: twice the mean inclination of the walls; positive: the walls open outwards
  std::optional<double> taper;
  std::optional<double> wall_depth;  // m, mean depth perpendicular to the old surface: the axial reduction of a crown
  std::optional<double> wall_thickness;    // m, smallest thickness of hard tissue behind the walls, below their rim
  std::optional<double> isthmus;           // m, smallest width across the cavity's length, at half its depth
  std::optional<double> margin_roughness;  // m rms, distance of the margin from the same margin smoothed over 0.25 mm
  std::optional<double> pulp_distance;     // m, distance from the new surface to the pulp; at most kPulpReach
  std::optional<double> pulp_exposed;      // m², area of exposed pulp; absent without pulp
  struct Cup {
    dvec3 center_W{0};  // m
    double radius = 0;  // m
    dvec3 axis_W{0};    // unit vector out of the opening; mean of the new surface's normals
  };
  std::optional<Cup> cup;            // sphere fitted to the new surface, for a reamed socket
  std::optional<double> cup_offset;  // m, distance between the centres of cup and ideal cup
  std::optional<double> cup_tilt;    // rad, angle between the axes of cup and ideal cup
  // m³, volume removed from tissue that must be kept; absent if no tissue must be kept
  std::optional<double> kept_removed;
};

/// m, limit of the measured distance to the pulp
inline constexpr double kPulpReach = 2e-3;

CavityMeasures measure_cavity(const Preparation& preparation);

/// Measures of the result, and of the ideal itself, which a perfect hand would achieve.
struct CavityAndIdeal {
  CavityMeasures result;
  std::optional<CavityMeasures> ideal;  // absent if there is no ideal
};
CavityAndIdeal measure_against_ideal(const Preparation& preparation);

}  // namespace typodont::session
