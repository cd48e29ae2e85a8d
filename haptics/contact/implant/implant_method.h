// The contact model "implant" simulates implant surgery after Zhao et al. 2020. Outside an implant bed, a tool moves
// freely (contact model "offset"). In a bed, it moves only along the bed's axis and rotates about it (README.md).
#pragma once

#include <optional>
#include <vector>

#include "haptics/contact_method.h"

namespace typodont::haptics::implant {

inline constexpr std::string_view kName = "implant";

/// An implant bed: a hole in the bone, or the bore of a placed implant. SI units; vectors in the workbench frame W.
struct Bed {
  dvec3 entry_W{0};        // m, point where the bed's axis crosses the bone's surface
  dvec3 axis_W{0, 0, -1};  // unit vector along the bed's axis, from the bone's surface to the bottom
  double depth = 0;        // m, depth of the bed, from its entry to its bottom
  double radius = 0;       // m, radius of the widest tool that has widened the bed
  double tapped = 0;  // m, length of the thread in the bed's wall, from the entry inward; 0: the wall has no thread
  bool bore = false;  // true: the bed is the bore of a placed implant
};

/// Parameters of the contact model "implant" in a scene file. SI units. Values without a cited source are our own
/// choices; README.md gives the reasons.
struct Parameters {
  // m, edge length of a tool voxel; Zhao 2020 (S1) uses 0.06 mm for a tool of 4.2 × 12 mm
  double tool_voxel = 0.06e-3;
  int layers = 2;  // thickness of the tool's outer layer, in tool voxels (Zhao 2020: "1~2")
  // m; criterion 1 for entering a bed (Zhao 2020, "implant criteria") is met if the distance of the tool's tip from the
  // bed's axis and the depth of the tip below the bed's entry are both less than this
  double centre_tolerance = 0.5e-3;
  // m; the tool may also enter while its tip is still in front of the entry, by at most this. The reason: a wide tool
  // touches a sloping rim before its tip has arrived at the entry.
  double rim_above = 1.5e-3;
  // m, tolerance by which the radius of a tool that does not widen the bed may exceed the bed's radius
  double radius_tolerance = 0.1e-3;
  // m; a drill may enter a bed and widen it if its radius exceeds the bed's radius by at most this
  double widening = 0.6e-3;
  // m, largest amount by which a tool's radius may be smaller than the bed's radius; a narrower tool moves freely in
  // the bed
  double loose = 0.75e-3;
  // rad (10 degrees), largest angle between the axes of tool and bed at which the tool may enter the bed
  double axis_tolerance = 0.175;
  // N; criterion 4 for entering a bed is met if the force along the tool's axis is larger than this
  double enter_force = 0.3;
  // m; hysteresis: the tool leaves the bed only when its tip is this far outside the entry
  double leave = 0.3e-3;
  double least_depth = 0.5e-3;  // m, smallest depth of a bed; a shallower hole does not count as a bed
  // Parameters of the motion in a bed.
  double mass = 0;              // kg, mass of the virtual tool in a bed (Zhao 2020, eq. 5); 0: the tool has no inertia
  double turn_stiffness = 1.0;  // N·m/rad, torsional stiffness that keeps the tool aligned with the bed's axis
  double switch_slew = 8;       // N/s, largest rate of change of the force after the tool has entered or left a bed
  // rad/s, largest rate of change of the orientation after the tool has entered or left a bed
  double turn_slew = 0.5;
  double sliding_drag = 2;  // N·s/m, viscous friction of a tool that slides in the bed
  double steps = 1;         // largest advance of the tool per tick, in voxels of the tissue (Zhao 2020, eq. 9)
  // true: eq. (7) of Zhao 2020 as printed; a tool in a bed then moves only if there is an obstacle. false: the
  // corrected equation (README.md).
  bool as_printed = false;
  // Hounsfield units, grey values of the tissues with the hardness 1
  double cortical_grey = 1650, cancellous_grey = 1250, tooth_grey = 3000, metal_grey = 10000,
         soft_grey = 50;  // Hounsfield units, grey value of nerve and gum
  // N·m, insertion torque of the reference implant (surface area torque_surface) in the reference bone (grey value
  // torque_grey). For other bone, this torque is multiplied by (grey value of the bone / torque_grey)^torque_exponent.
  // If an earlier tool has cut a thread into the bed's wall, it is also multiplied by tapped_share.
  double torque = 0.489;
  // Hounsfield units, grey value of the reference bone; it corresponds to a density of 0.64 g/cm³
  double torque_grey = 1050;
  // exponent of the grey value in the insertion torque; fitted to 48.9 N·cm at 0.64 g/cm³ and 11.7 N·cm at 0.32 g/cm³
  double torque_exponent = 2.06;
  double torque_surface = 163e-6;  // m², surface area of the reference implant of 4 × 13 mm
  // ratio of the insertion torque in a bed with a cut thread to that in a bed without a thread
  double tapped_fraction = 0.6;
  std::vector<Bed> beds;  // beds that exist at the start of the session
};

/// Reads the parameters described in README.md from a scene file. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::implant
