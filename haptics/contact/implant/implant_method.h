// "implant": contact for implant surgery after Zhao et al. 2020. On the bone a tool moves freely (the offset model), in
// an implant bed only along and about the bed's axis (README.md).
#pragma once

#include <optional>
#include <vector>

#include "haptics/contact_method.h"

namespace typodont::haptics::implant {

inline constexpr std::string_view kName = "implant";

/// An implant bed: a hole in the bone, or the bore of a placed implant. SI, frame W.
struct Bed {
  dvec3 entry_W{0};        // on the bone's surface, on the axis
  dvec3 axis_W{0, 0, -1};  // unit, from the surface to the bottom
  double depth = 0;        // m, from the entry to the tip
  double radius = 0;       // m, of the widest tool that went in
  double tapped = 0;       // m from the entry that have a thread
  bool bore = false;       // of a placed implant
};

/// What a scene's model may say. SI. Values without another source are ours; README.md has the reasons.
struct Parameters {
  double tool_voxel = 0.06e-3;  // m; five_methods S1: the tool of 4.2 × 12 mm at 0.06 mm
  int layers = 2;               // of voxels that keep the contact ("1~2", Zhao 2020)
  // The criteria for a bed (Zhao 2020, "implant criteria").
  double centre_tolerance = 0.5e-3;  // m from the tip to the bed's axis, and from its entry
  double rim_above = 1.5e-3;         // m before the entry: a wider tool meets a sloping rim before it comes there
  double radius_tolerance = 0.1e-3;  // m that a tool which does not widen may be wider than the bed
  double widening = 0.6e-3;          // m that a drill's radius may exceed the bed's
  double loose = 0.75e-3;            // m: a tool narrower than the bed by more moves freely in it
  double axis_tolerance = 0.175;     // rad (10 degrees) between tool and bed
  double enter_force = 0.3;          // N along the axis
  double leave = 0.3e-3;             // m that the tip must be out of the bed: the hysteresis
  double least_depth = 0.5e-3;       // m: a shallower hole is no bed
  // Motion in a bed.
  double mass = 0;              // kg of the virtual tool, eq. (5)
  double turn_stiffness = 1.0;  // N·m/rad that holds the tool along the bed's axis
  double switch_slew = 8;       // N/s by which the force may change because of a switch
  double turn_slew = 0.5;       // rad/s of the tool because of a switch
  double sliding_drag = 2;      // N·s/m
  double steps = 1;             // voxels of bone that the tool may advance in a tick, eq. (9)
  bool as_printed = false;      // eq. (7) as it stands in the paper: no advance without an obstacle
  // Grey values, Hounsfield units, of tissues at hardness 1.
  double cortical_grey = 1650, cancellous_grey = 1250, tooth_grey = 3000, metal_grey = 10000,
         soft_grey = 50;  // of nerve and gum
  // Insertion torque: reference · (grey / reference_grey)^exponent over the reference surface, less in a tapped bed.
  double torque = 0.489;           // N·m, of the reference
  double torque_grey = 1050;       // HU that stand for its 0.64 g/cm³
  double torque_exponent = 2.06;   // from 48.9 N·cm at 0.64 g/cm³ and 11.7 N·cm at 0.32 g/cm³
  double torque_surface = 163e-6;  // m², of an implant of 4 × 13 mm
  double tapped_share = 0.6;       // of the torque where the bed has a thread
  std::vector<Bed> beds;           // that are there when the session begins
};

/// The keys of README.md. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::implant
