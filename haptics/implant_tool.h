// Cutting ability, thread and marks of instruments for implant surgery.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"

namespace typodont::haptics {

/// Purpose of an instrument in an implant set.
enum class ImplantToolKind {
  kRound,    // round bur: cuts on all sides, moves freely
  kDrill,    // drill: makes a bed, or widens or deepens it along its axis
  kGauge,    // gauge: measures a bed (drilled hole), never cuts
  kTap,      // thread tap: cuts a thread; advances by rotation
  kImplant,  // implant: has a thread; remains in the bone
  kScrew,    // screw: closes an implant and stays in it
};
std::string_view name_of(ImplantToolKind kind) noexcept;

/// "implant" of a tool's file, SI. Zhao 2020, "Modeling of the tools".
struct ImplantTool {
  ImplantToolKind kind = ImplantToolKind::kGauge;
  // Of the tool's voxels, 0 to 1, by their place.
  double end_ability = 0;     // at the end, beyond `centre_radius`
  double centre_ability = 0;  // at the end, within `centre_radius`
  double side_ability = 0;    // cutting ability on the side of the tool
  double centre_radius = 0;   // m from the axis
  double greatest_grey = 0;   // Hounsfield units; denser bone stops the tool
  // alpha of eq. (2), Zhao 2020: tangential / normal force at the edge
  double thrust_ratio = 1;
  double pitch = 0;          // m per turn; 0: none
  double core_diameter = 0;  // m, of the core; 0 without thread
  double bore_diameter = 0;  // m, inner thread for a screw; 0: none
  double bore_depth = 0;     // m, of the inner thread
  double speed = 0;          // rad/s, the manufacturer's; 0: does not rotate
  // rad/s at full pedal with a reduction gear; 0: the motor's
  double top_speed = 0;
  bool by_hand = false;        // turned by hand (ratchet)
  bool irrigated = false;      // true: the tool needs cooling water
  double greatest_torque = 0;  // N·m, the manufacturer's limit; 0: not stated
  // m above the free end, rings of the scale, ascending
  std::vector<double> marks;

  bool threaded() const { return pitch > 0; }
  /// Implants and screws stay where they are seated.
  bool stays() const { return kind == ImplantToolKind::kImplant || kind == ImplantToolKind::kScrew; }
};

/// `diameter`, `length`: m, of the head. Throws Error.
ImplantTool read_implant_tool(const Json& json, double diameter, double length);

}  // namespace typodont::haptics
