// Instruments of implant surgery: cutting ability, thread and depth marks.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"

namespace typodont::haptics {

/// Purpose of an instrument in an implant set.
enum class ImplantToolKind {
  kRound,    // round bur: cuts on all sides, moves in any direction
  kDrill,    // drill: makes an implant bed (the drilled hole), or widens or deepens it along its axis
  kGauge,    // gauge: measures the depth of an implant bed (the drilled hole), never cuts
  kTap,      // thread tap: cuts a thread; advances by rotation
  kImplant,  // implant: has a thread; remains in the bone
  kScrew,    // screw: closes an implant and stays in it
};
std::string_view name_of(ImplantToolKind kind) noexcept;

/// Value of the key "implant" in a tool's file, in SI units. Zhao 2020, "Modeling of the tools".
struct ImplantTool {
  ImplantToolKind kind = ImplantToolKind::kGauge;
  // Cutting ability, 0 to 1, of the voxels that represent the tool. It depends on their position.
  double end_ability = 0;     // cutting ability on the end face outside `centre_radius`
  double centre_ability = 0;  // cutting ability on the end face, within `centre_radius` of the axis
  double side_ability = 0;    // cutting ability on the side of the tool
  double centre_radius = 0;   // m, radius within which the end face's cutting ability is centre_ability
  double max_grey = 0;        // Hounsfield units; denser bone stops the tool
  // Alpha of eq. (2), Zhao 2020: ratio of tangential to normal force at the edge.
  double thrust_ratio = 1;
  double pitch = 0;          // m, advance of the thread per turn; 0: no thread
  double core_diameter = 0;  // m, core diameter of the thread; 0: no thread
  double bore_diameter = 0;  // m, diameter of the implant's inner thread for a screw; 0: none
  double bore_depth = 0;     // m, depth of the inner thread
  double speed = 0;          // rad/s, speed that the manufacturer states; 0: the tool does not rotate
  // Speed at full pedal with a reduction gear, rad/s; 0: speed of the motor.
  double top_speed = 0;
  bool by_hand = false;    // turned by hand (ratchet)
  bool irrigated = false;  // true: the tool needs cooling water
  double max_torque = 0;   // N·m, the manufacturer's limit; 0: not stated
  // Heights of the rings (depth marks) above the free end, m, ascending.
  std::vector<double> marks;

  bool threaded() const { return pitch > 0; }
  /// Returns true for implants and screws, which remain in the patient.
  bool stays() const { return kind == ImplantToolKind::kImplant || kind == ImplantToolKind::kScrew; }
};

/// Reads the key "implant". `diameter`, `length`: size of the head, m. Throws Error.
ImplantTool read_implant_tool(const Json& json, double diameter, double length);

}  // namespace typodont::haptics
