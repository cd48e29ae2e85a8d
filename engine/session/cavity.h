// Geometry of a preparation: compares the tissue removed (or added) with the ideal. Pure functions of dense fields,
// with no error beyond that of the fields; without haptics or surface mesher. Lengths in metres.
#pragma once

#include <optional>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "engine/session/dense_field.h"

namespace typodont::session {

/// One piece of tissue before, after and in its ideal form, all on the same voxels.
struct Preparation {
  VoxelFrame frame;            // sample (0,0,0) lies at the frame's origin
  DenseField before, after;    // at the start and at the end
  DenseField ideal;            // the ideal result; empty: the task has none
  std::vector<Tissue> tissue;  // labels at the start
  std::vector<bool> keep;      // voxels that must not be removed (a neighbouring tooth); may be empty
  dvec3 axis_W{0, 0, 1};       // unit, out of the opening: from where the bur approaches and where a crown is placed
};

struct Place {
  double depth = 0;  // m
  dvec3 p_W{0};      // valid if depth > 0
};

/// SI units. A measure that this preparation does not have (no floor, no pulp …) is absent.
struct CavityMeasures {
  bool has_ideal = false;
  double wanted = 0;        // m³ that the ideal removes or adds
  double done = 0;          // m³ of `wanted` that was done
  double over_volume = 0;   // m³ missing although the ideal keeps (or adds) them
  double under_volume = 0;  // m³ present although the ideal removes them (or too much filling)
  Place over, under;        // largest deviations of the surface into the tissue and out of it
  // m rms distance from the ideal's surface, over all parts that changed or should have changed, without closed
  // pores
  std::optional<double> contour;

  double cut_area = 0;                   // m², area of new surface
  std::optional<double> floor_depth;     // m, mean depth along the axis below the old surface
  std::optional<double> floor_flatness;  // m rms distance from the floor's plane
  std::optional<double> floor_tilt;      // rad between the floor's plane and the axis
  // rad, total occlusal convergence: twice the mean inclination of the walls; above 0 they open outwards
  std::optional<double> taper;
  std::optional<double> wall_depth;  // m, mean depth perpendicular to the old surface: the axial reduction of a crown
  std::optional<double> wall_thickness;    // m, smallest thickness of hard tissue behind the walls, below their rim
  std::optional<double> isthmus;           // m, smallest width across the cavity's length, at half its depth
  std::optional<double> margin_roughness;  // m rms distance of the margin from the margin smoothed over 0.25 mm
  std::optional<double> pulp_distance;     // m from the new surface to the pulp; at most kPulpReach
  std::optional<double> pulp_exposed;      // m² of exposed pulp; absent without pulp
  struct Cup {
    dvec3 center_W{0};  // m
    double radius = 0;  // m
    dvec3 axis_W{0};    // unit, out of the opening: the mean of the new surface's normals
  };
  std::optional<Cup> cup;              // sphere fitted to the new surface, for a reamed socket
  std::optional<double> cup_offset;    // m between the centres of cup and ideal cup
  std::optional<double> cup_tilt;      // rad between the axes of cup and ideal cup
  std::optional<double> kept_removed;  // m³ removed from tissue that must be kept; absent if there is none
};

/// m, largest distance to the pulp that is measured
inline constexpr double kPulpReach = 2e-3;

CavityMeasures measure_cavity(const Preparation& preparation);

/// Measures of the result, and of the ideal itself, which a perfect hand would reach.
struct CavityAndIdeal {
  CavityMeasures result;
  std::optional<CavityMeasures> ideal;  // absent if there is no ideal
};
CavityAndIdeal measure_against_ideal(const Preparation& preparation);

}  // namespace typodont::session
