// Zhao et al. 2020. Outside a bed as "offset"; in it, along the axis and about it (README.md).
#pragma once

#include <optional>
#include <vector>

#include "haptics/contact_method.h"

namespace typodont::haptics::implant {

inline constexpr std::string_view kName = "implant";

/// A hole in bone, or a placed implant's bore. SI, W.
struct Bed {
  dvec3 entry_W{0};        // m, where the axis meets the bone's surface
  dvec3 axis_W{0, 0, -1};  // unit vector to the bottom
  double depth = 0;        // m, entry to bottom
  double radius = 0;       // m, widest tool so far
  double tapped = 0;       // m from the entry inward; 0: none
  bool bore = false;       // of a placed implant
};

/// SI. Without a source: our choice, reasons in README.md.
struct Parameters {
  // m, edge; Zhao 2020: 0.06 mm for 4.2 × 12 mm
  double tool_voxel = 0.06e-3;
  int layers = 2;  // tool voxels (Zhao 2020: "1~2")
  // m of the tip from the axis, and below the entry: criterion 1
  double centre_tolerance = 0.5e-3;
  // m before the entry, too: a wide tool meets a sloping rim first
  double rim_above = 1.5e-3;
  // m wider than the bed, for tools that do not widen it
  double radius_tolerance = 0.1e-3;
  // m wider, for a drill that does
  double widening = 0.6e-3;
  // m narrower, at most; below, it moves freely in the bed
  double loose = 0.75e-3;
  // rad (10 degrees) between the axes
  double axis_tolerance = 0.175;
  // N along the axis: criterion 4
  double enter_force = 0.3;
  // m outside the entry, to leave
  double leave = 0.3e-3;
  double least_depth = 0.5e-3;  // m; shallower holes are no beds
  // Parameters of the motion in a bed.
  double mass = 0;              // kg (Zhao 2020, eq. 5); 0: no inertia
  double turn_stiffness = 1.0;  // N·m/rad, to the axis
  double switch_slew = 8;       // N/s after entering or leaving
  // rad/s after entering or leaving
  double turn_slew = 0.5;
  double sliding_drag = 2;  // N·s/m, sliding in the bed
  double steps = 1;         // voxels per tick (Zhao 2020, eq. 9)
  // eq. (7) as printed: moves only at an obstacle; otherwise corrected (README.md)
  bool as_printed = false;
  // Hounsfield units at hardness 1
  double cortical_grey = 1650, cancellous_grey = 1250, tooth_grey = 3000, metal_grey = 10000,
         soft_grey = 50;  // Hounsfield units, grey value of nerve and gum
  // N·m of the reference implant (torque_surface) in reference bone (torque_grey); × (grey /
  // torque_grey)^torque_exponent, and × tapped_share in a cut thread.
  double torque = 0.489;
  // Hounsfield units, 0.64 g/cm³
  double torque_grey = 1050;
  // fitted to 48.9 N·cm at 0.64 and 11.7 N·cm at 0.32 g/cm³
  double torque_exponent = 2.06;
  double torque_surface = 163e-6;  // m², of 4 × 13 mm
  // of the insertion torque, with a cut thread
  double tapped_fraction = 0.6;
  std::vector<Bed> beds;  // at the start
};

/// README.md. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::implant
