// The contact method "implant" (Zhao et al. 2020). Outside an implant bed (the drilled hole), it behaves as "offset";
// in a bed, the tool moves along and about the bed's axis (README.md).
#pragma once

#include <optional>
#include <vector>

#include "haptics/contact_method.h"

namespace typodont::haptics::implant {

inline constexpr std::string_view kName = "implant";

/// A hole in bone, or an implant's bore. Frame W.
struct Bed {
  dvec3 entry_W{0};        // m, point where the axis meets the bone's surface
  dvec3 axis_W{0, 0, -1};  // unit vector to the bottom
  double depth = 0;        // m, from the entry to the bottom
  double radius = 0;       // m, radius of the widest tool so far
  double tapped = 0;       // m, depth to which a thread was cut; 0: none
  bool bore = false;       // true: the bore of a placed implant
};

/// SI. Values without a source are explained in README.md.
struct Parameters {
  // m, edge of a tool voxel. Zhao 2020: 0.06 mm for a tool of 4.2 × 12 mm.
  double tool_voxel = 0.06e-3;
  // m; criterion 1 for entering a drilled hole: largest distance of the tip from the axis, and largest depth of the tip
  double centre_tolerance = 0.5e-3;
  // m; criterion 1 for entering a drilled hole: largest height of the tip above the entry (wide tools rest on the rim)
  double rim_above = 1.5e-3;
  // m; criterion 2 for entering a drilled hole: largest (tool radius - hole radius) of a tool that does not widen it
  double radius_tolerance = 0.1e-3;
  // m; criterion 2 for entering a drilled hole: largest (tool radius - hole radius) of a drill or an implant's core
  double widening = 0.6e-3;
  // m; criterion 2 for entering a drilled hole: largest (hole radius - tool radius); narrower tools move freely in it
  double loose = 0.75e-3;
  // rad (10 degrees); criterion 3 for entering a drilled hole: largest angle between the axes of tool and hole
  double axis_tolerance = 0.175;
  // N; criterion 4 for entering a drilled hole: smallest force with which the hand pushes along the hole's axis
  double enter_force = 0.3;
  // m; the tool leaves the drilled hole when its tip is this far outside the entry
  double leave = 0.3e-3;
  double min_depth = 0.5e-3;  // m; a shallower hole is not a bed
  // kg, tool's mass for the motion along a bed (Zhao 2020, eq. 5); 0: no inertia
  double mass = 0;              // kg (Zhao 2020, eq. 5); 0: no inertia
  double turn_stiffness = 1.0;  // N·m/rad, spring that turns the tool to the bed's axis
  double switch_slew = 8;       // N/s, largest rate of the force after the tool has entered or left a bed
  // rad/s, largest rate at which the tool's axis tilts after the tool has entered or left a bed (drilled hole)
  double turn_slew = 0.5;
  double sliding_drag = 2;  // N·s/m, drag of sliding in the bed
  double steps = 1;         // voxels, largest motion per tick (Zhao 2020, eq. 9)
  // true: eq. 7 of Zhao 2020 as printed, where the tool moves only at an obstacle; false: corrected (README.md)
  bool as_printed = false;
  // Hounsfield units, grey value of each tissue at hardness 1
  double cortical_grey = 1650, cancellous_grey = 1250, tooth_grey = 3000, metal_grey = 10000,
         soft_grey = 50;  // grey value of nerve and gum
  // N·m, insertion torque of a reference implant (surface torque_surface) in reference bone (grey value torque_grey).
  // In other bone, multiplied by (grey / torque_grey)^torque_exponent; in a bed with a cut thread, by tapped_fraction.
  double torque = 0.489;
  // Hounsfield units, grey value of the reference bone with the density 0.64 g/cm³
  double torque_grey = 1050;
  // exponent of the bone's grey value, fitted to measured torques: 48.9 N·cm at 0.64 g/cm³ and 11.7 N·cm at 0.32 g/cm³
  double torque_exponent = 2.06;
  double torque_surface = 163e-6;  // m², surface of the reference implant, 4 × 13 mm
  // insertion torque in a bed with a cut thread divided by the torque in a bed without thread
  double tapped_fraction = 0.6;
  std::vector<Bed> beds;  // implant beds (drilled holes) at the start of the session
};

/// Reads the method's parameters (README.md). Throws Error.
SharedContactMethod read(Keys& keys);

}  // namespace typodont::haptics::implant
