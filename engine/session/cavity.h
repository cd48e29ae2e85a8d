// Removed or added tissue against the ideal, from dense distance fields, without state. Lengths in m, as exact as the
// fields.
#pragma once

#include <optional>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "engine/session/dense_field.h"

namespace typodont::session {

/// Before, after and ideal, on one grid.
struct Preparation {
  VoxelFrame frame;            // sample (0,0,0) is at its origin
  DenseField before, after;    // distance fields before and after the work
  DenseField ideal;            // empty without an ideal
  std::vector<Tissue> tissue;  // tissue of each voxel before the work
  std::vector<bool> keep;      // must not be removed: a neighbouring tooth; may be empty
  // unit vector out of the opening, from which a crown is placed
  dvec3 axis_W{0, 0, 1};
};

struct Place {
  double depth = 0;  // m, off the ideal; 0: none
  dvec3 p_W{0};      // m, if depth > 0
};

/// SI units. Empty where it does not apply, for example without a floor.
struct CavityMeasures {
  bool has_ideal = false;
  double wanted = 0;        // m³ that the ideal removes or adds
  double done = 0;          // m³ of `wanted` that is done
  double over_volume = 0;   // m³ missing although the ideal has it
  double under_volume = 0;  // m³ left although the ideal removes it, or excess filling
  // farthest from the ideal, into the tissue and out of it
  Place over, under;
  // m, root mean square from the ideal, where the surface changed or should have; without closed pores
  std::optional<double> contour;

  double cut_area = 0;                   // m², area of the new surface
  std::optional<double> floor_depth;     // m, mean below the old surface, along axis_W
  std::optional<double> floor_flatness;  // m, root mean square from a plane
  std::optional<double> floor_tilt;      // rad, from the plane across axis_W
  // rad, total occlusal convergence: twice the walls' mean inclination; positive: opening outwards
  std::optional<double> taper;
  // m, mean, perpendicular to the old surface (crown: axial reduction)
  std::optional<double> wall_depth;
  // m, least hard tissue behind the walls, without the rim
  std::optional<double> wall_thickness;
  std::optional<dvec3> thinnest_W;  // m, where
  std::optional<double> isthmus;    // m, least width across the longer axis, at half depth
  // m, root mean square from the margin smoothed over 0.25 mm
  std::optional<double> margin_roughness;
  // m, least from the new surface, up to kPulpReach
  std::optional<double> pulp_distance;
  std::optional<dvec3> nearest_pulp_W;  // m, on the new surface
  std::optional<double> pulp_exposed;   // m²; empty without pulp
  struct Cup {
    dvec3 center_W{0};  // m, W, of the sphere fitted to a reamed socket
    double radius = 0;  // m, of that sphere
    dvec3 axis_W{0};    // out of the opening, mean normal
  };
  std::optional<Cup> cup;            // sphere fitted to a reamed socket
  std::optional<double> cup_offset;  // m, from the ideal's centre
  std::optional<double> cup_tilt;    // rad, from the ideal's axis
  // m³ of tissue that must stay; empty without such.
  std::optional<double> kept_removed;
};

/// m from the pulp that is measured.
inline constexpr double kPulpReach = 2e-3;

CavityMeasures measure_cavity(const Preparation& preparation);

/// Of the result, and of the ideal, which a perfect hand reaches.
struct CavityAndIdeal {
  CavityMeasures result;
  std::optional<CavityMeasures> ideal;  // no value if the task has no ideal
};
/// Slow, and the same for all results of a task: depends on the tissue before and the ideal only.
struct CavityReference {
  TrueDistances before;
  std::optional<TrueDistances> ideal;      // no value if the task has no ideal
  std::vector<bool> pulp;                  // true for each voxel of pulp
  std::vector<std::size_t> to_pulp;        // nearest pulp voxel per voxel; empty without pulp
  std::optional<CavityMeasures> measures;  // empty without an ideal
};
CavityReference cavity_reference(const Preparation& preparation);
/// `reference`: same grid, same tissue before, same ideal.
CavityAndIdeal measure_against_ideal(const Preparation& preparation, const CavityReference& reference);

}  // namespace typodont::session
