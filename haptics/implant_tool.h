// Properties of an instrument for implant surgery other than its shape: cutting ability, thread and marks.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"

namespace typodont::haptics {

/// Purpose of an instrument in an implant set.
enum class ImplantToolKind {
  kRound,    // round bur: cuts on all sides and moves freely, even in a bed (a drilled hole)
  kDrill,    // drill: makes a bed (hole), or makes it deeper or wider, along its axis
  kGauge,    // gauge: measures a bed (drilled hole), never cuts
  kTap,      // thread tap: cuts a thread; advances by rotation
  kImplant,  // implant: has a thread; remains in the bone
  kScrew,    // screw: closes an implant; has a thread; remains in the implant
};
std::string_view name_of(ImplantToolKind kind) noexcept;

/// The block "implant" of a tool's file. SI units. Zhao 2020, "Modeling of the tools".
struct ImplantTool {
  ImplantToolKind kind = ImplantToolKind::kGauge;
  // Cutting abilities of the tool's voxels, from 0 (cannot cut) to 1 (cuts fully). The ability depends on where the
  // voxel is in the tool.
  double end_ability = 0;     // cutting ability at the tool's end, farther than `centre_radius` from the axis
  double centre_ability = 0;  // cutting ability at the tool's end, within `centre_radius` of the axis
  double side_ability = 0;    // cutting ability on the side of the tool
  double centre_radius = 0;   // m, radius around the axis in which `centre_ability` applies
  double greatest_grey = 0;   // Hounsfield units; bone with a larger grey value than this stops the tool
  // alpha of eq. (2) in Zhao 2020: tangential force divided by normal force at the cutting edge
  double thrust_ratio = 1;
  double pitch = 0;          // m, advance per turn of the thread; 0: no thread
  double core_diameter = 0;  // m, core diameter of the thread; 0 without a thread
  double bore_diameter = 0;  // m, diameter of the inner thread of an implant, which receives a screw; 0: none
  double bore_depth = 0;     // m, depth of the inner thread that receives a screw
  double speed = 0;          // rad/s, speed that the manufacturer recommends; 0: the tool does not rotate
  // rad/s, speed at full pedal if a reduction gear drives the tool; 0: there is no gear, so the tool has the motor's
  // speed
  double top_speed = 0;
  bool by_hand = false;        // true: a hand rotates the tool (ratchet), not the motor
  bool irrigated = false;      // true: the tool needs cooling water
  double greatest_torque = 0;  // N·m, largest torque that the manufacturer permits; 0: not stated
  // m, heights above the free end at which the tool has the rings of its depth scale, ascending
  std::vector<double> marks;

  bool threaded() const { return pitch > 0; }
  /// Returns true for an implant or a screw, which remain in place after they are seated.
  bool stays() const { return kind == ImplantToolKind::kImplant || kind == ImplantToolKind::kScrew; }
};

/// Reads the block "implant" of a tool's file. `diameter`, `length`: size of the tool's head, m. Throws Error.
ImplantTool read_implant_tool(const Json& json, double diameter, double length);

}  // namespace typodont::haptics
