// The geometry of a preparation: what was taken away (or added), against what should have been. Pure functions of dense
// fields, exact to the fields' own error; no haptics, no surface mesher. Lengths come out in metres.
#pragma once

#include <optional>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "engine/session/dense_field.h"

namespace typodont::session {

/// One piece of tissue at three moments, all on the same voxels.
struct Preparation {
  VoxelFrame frame;            // sample (0,0,0) lies at its origin
  DenseField before, after;    // at the start, and as it was left
  DenseField ideal;            // as it should have been left; empty: the task names none
  std::vector<Tissue> tissue;  // labels at the start
  std::vector<bool> keep;      // voxels that must not be touched (a neighbour); may be empty
  dvec3 axis_W{0, 0, 1};       // unit, out of the opening: where the bur comes from, where a crown is put on
};

struct Place {
  double depth = 0;  // m
  dvec3 p_W{0};      // meaningful where depth > 0
};

/// SI. What cannot be said of this preparation (no floor, no pulp …) is absent.
struct CavityMeasures {
  bool has_ideal = false;
  double wanted = 0;        // m³ that the ideal takes away or adds
  double done = 0;          // m³ of that
  double over_volume = 0;   // m³ missing that the ideal leaves (or adds)
  double under_volume = 0;  // m³ still there that the ideal takes away (or too much of a filling)
  Place over, under;        // where the surface lies farthest inside and outside the ideal
  std::optional<double>
      contour;  // m rms, from the ideal's surface, over all that was to be changed or was changed, without closed pores

  double cut_area = 0;                   // m² of new surface
  std::optional<double> floor_depth;     // m, mean, along the axis below the surface there was
  std::optional<double> floor_flatness;  // m rms from the floor's plane
  std::optional<double> floor_tilt;      // rad, that plane against the axis
  std::optional<double> taper;           // rad, total: twice the mean lean of the walls; above 0 they open outward
  std::optional<double> wall_depth;      // m, mean, square to the surface there was: the axial reduction of a crown
  std::optional<double> wall_thickness;  // m, of hard tissue behind the walls, below their rim, where they are thinnest
  std::optional<double> isthmus;         // m, narrowest width across the cavity's length, half-way down
  std::optional<double> margin_roughness;  // m rms, the margin against itself smoothed over a quarter of a millimetre
  std::optional<double> pulp_distance;     // m, from the new surface to the pulp; at most kPulpReach
  std::optional<double> pulp_exposed;      // m² of pulp laid open; absent without pulp
  struct Cup {
    dvec3 center_W{0};  // m
    double radius = 0;  // m
    dvec3 axis_W{0};    // unit, out of the opening: the mean of the new surface's normals
  };
  std::optional<Cup> cup;              // the sphere that fits the new surface best: of a reamed socket
  std::optional<double> cup_offset;    // m, its centre from that of the ideal's
  std::optional<double> cup_tilt;      // rad, its axis against that of the ideal's
  std::optional<double> kept_removed;  // m³ taken from what must not be touched; absent without such a thing
};

/// Pulp farther away than this is no nearer than it must be. m
inline constexpr double kPulpReach = 2e-3;

CavityMeasures measure_cavity(const Preparation& preparation);

/// The result's, and the ideal's own: what a perfect hand would get.
struct CavityAndIdeal {
  CavityMeasures result;
  std::optional<CavityMeasures> ideal;  // absent without one
};
CavityAndIdeal measure_against_ideal(const Preparation& preparation);

}  // namespace typodont::session
