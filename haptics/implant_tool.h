// Properties of an instrument for implant surgery except its shape: cutting ability, thread, marks.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"

namespace typodont::haptics {

/// Purpose of an instrument in an implant set.
enum class ImplantToolKind {
  kRound,    // ball that cuts on all sides and moves freely, also in a bed
  kDrill,    // begins, deepens or widens a bed along its axis
  kGauge,    // measures, never cuts
  kTap,      // cuts a thread; advances by rotation
  kImplant,  // has a thread; stays in the bone
  kScrew,    // closes an implant; has a thread; stays
};
std::string_view name_of(ImplantToolKind kind) noexcept;

/// The block "implant" of a tool's file. SI. Zhao 2020, "Modeling of the tools".
struct ImplantTool {
  ImplantToolKind kind = ImplantToolKind::kGauge;
  // Cutting ability of the tool's voxels, 0 (none) to 1; it depends on the voxel's position
  double end_ability = 0;     // cutting ability at the end, farther than `centre_radius` from the axis
  double centre_ability = 0;  // cutting ability at the end, within `centre_radius` of the axis
  double side_ability = 0;    // cutting ability on the flank
  double centre_radius = 0;   // m, limit of the distance from the axis for `centre_ability`
  double greatest_grey = 0;   // Hounsfield units, limit: bone with a higher grey value stops the tool
  double thrust_ratio = 1;    // alpha of eq. (2): ratio of tangential to normal force of the teeth
  double pitch = 0;           // m, advance per turn; 0: no thread
  double core_diameter = 0;   // m, core diameter of the thread; 0 without a thread
  double bore_diameter = 0;   // m, diameter of the inner thread of an implant that takes a screw; 0: none
  double bore_depth = 0;      // m, depth of the inner thread
  double speed = 0;           // rad/s, speed that the manufacturer recommends; 0: the tool does not turn
  double top_speed = 0;  // rad/s at full pedal, if the handpiece is geared down for this tool; 0: the motor's own speed
  bool by_hand = false;  // the tool is turned by hand (ratchet), not by the motor
  bool irrigated = false;      // the tool needs cooling water
  double greatest_torque = 0;  // N·m, limit stated by the manufacturer; 0: not stated
  std::vector<double> marks;   // m, heights of the depth scale's rings above the free end, ascending

  bool threaded() const { return pitch > 0; }
  /// Returns true if the part stays in the bone after it is seated.
  bool stays() const { return kind == ImplantToolKind::kImplant || kind == ImplantToolKind::kScrew; }
};

/// Throws Error. `diameter`, `length`: m, size of the tool's head.
ImplantTool read_implant_tool(const Json& json, double diameter, double length);

}  // namespace typodont::haptics
