// "implant": contact for implant surgery after Zhao et al. 2020. On the bone a tool moves freely (the offset model); in
// an implant bed it moves only along the bed's axis and rotates about it (README.md).
#pragma once

#include <optional>
#include <vector>

#include "haptics/contact_method.h"

namespace typodont::haptics::implant {

inline constexpr std::string_view kName = "implant";

/// An implant bed: a hole in the bone, or the bore of a placed implant. SI, frame W.
struct Bed {
  dvec3 entry_W{0};        // point on the axis at the bone's surface
  dvec3 axis_W{0, 0, -1};  // unit vector from the surface to the bottom
  double depth = 0;        // m, distance from the entry to the tip
  double radius = 0;       // m, radius of the widest tool that has entered
  double tapped = 0;       // m, length of the thread from the entry
  bool bore = false;       // this is the bore of a placed implant
};

/// Parameters of the contact model `implant` in a scene's file. SI units. Values without a cited source are our own
/// choice; README.md gives the reasons.
struct Parameters {
  // m, edge of a voxel of the tool; Zhao 2020 (S1) uses 0.06 mm for a tool of 4.2 × 12 mm
  double tool_voxel = 0.06e-3;
  int layers = 2;  // number of voxel layers for the contact ("1~2", Zhao 2020)
  // Criteria for entering a bed (Zhao 2020, "implant criteria").
  double centre_tolerance = 0.5e-3;  // m, largest distance of the tip from the bed's axis, and from its entry
  // m, distance in front of the entry within which the tip counts as being at the entry, because a wide tool touches
  // a sloping rim before its tip is at the entry
  double rim_above = 1.5e-3;
  // m, largest amount by which the radius of a tool that does not widen the bed may exceed the bed's radius
  double radius_tolerance = 0.1e-3;
  double widening = 0.6e-3;  // m, largest amount by which a drill's radius may exceed the bed's radius
  // m, largest amount by which a tool's radius may be less than the bed's; a narrower tool moves freely in the bed
  double loose = 0.75e-3;
  double axis_tolerance = 0.175;  // rad (10 degrees), largest angle between tool and bed
  double enter_force = 0.3;       // N along the axis, threshold for entering
  double leave = 0.3e-3;          // m, distance of the tip from the entry at which the tool leaves the bed (hysteresis)
  double least_depth = 0.5e-3;    // m, least depth of a bed; a shallower hole is not a bed
  // Parameters of the motion in a bed.
  double mass = 0;              // kg, mass of the virtual tool, eq. (5)
  double turn_stiffness = 1.0;  // N·m/rad, torsional stiffness that keeps the tool aligned with the bed's axis
  double switch_slew = 8;       // N/s, limit of the change of force after the tool entered or left a bed
  double turn_slew = 0.5;       // rad/s, limit of the change of orientation after the tool entered or left a bed
  double sliding_drag = 2;      // N·s/m, friction of sliding in the bed
  double steps = 1;             // voxels of bone, largest advance in a tick, eq. (9)
  // true: eq. (7) of Zhao 2020 as printed, with which a tool does not advance unless an obstacle lies ahead; false: the
  // corrected equation (README.md)
  bool as_printed = false;
  // Grey values in Hounsfield units of tissues at hardness 1.
  double cortical_grey = 1650, cancellous_grey = 1250, tooth_grey = 3000, metal_grey = 10000,
         soft_grey = 50;  // grey value of nerve and gum
  // Insertion torque of an implant with the surface torque_surface: torque · (grey / torque_grey)^torque_exponent. In
  // a tapped bed, this value is multiplied by tapped_share.
  double torque = 0.489;           // N·m, reference torque
  double torque_grey = 1050;       // HU that correspond to the reference density of 0.64 g/cm³
  double torque_exponent = 2.06;   // from 48.9 N·cm at 0.64 g/cm³ and 11.7 N·cm at 0.32 g/cm³
  double torque_surface = 163e-6;  // m², surface of the reference implant of 4 × 13 mm
  double tapped_share = 0.6;       // fraction of the torque that remains if the bed has a thread
  std::vector<Bed> beds;           // beds that exist at the session's start
};

/// Reads the keys described in README.md. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::implant
