// What an instrument for implant surgery is beside its shape: where it cuts, what it cannot cut, its thread, its marks.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"

namespace typodont::haptics {

/// What an instrument of an implant set is for.
enum class ImplantToolKind {
  kRound,    // a ball that cuts all around and moves freely, also in a bed
  kDrill,    // begins, deepens or widens a bed along its axis
  kGauge,    // only measures
  kTap,      // cuts a thread; moves by turning
  kImplant,  // has a thread; stays in the bone
  kScrew,    // closes an implant; has a thread; stays
};
std::string_view name_of(ImplantToolKind kind) noexcept;

/// The block "implant" of a tool's file. SI. Zhao 2020, "Modeling of the tools".
struct ImplantTool {
  ImplantToolKind kind = ImplantToolKind::kGauge;
  // Drilling ability of the tool's voxels, 0 (none) to 1, by where they lie.
  double end_ability = 0;      // on the end, outside its centre
  double centre_ability = 0;   // on the end within `centre_radius` of the axis
  double side_ability = 0;     // on the flank
  double centre_radius = 0;    // m
  double greatest_grey = 0;    // Hounsfield units: bone of a higher grey value stops the tool
  double thrust_ratio = 1;     // alpha of eq. (2): tangential over normal force of the teeth
  double pitch = 0;            // m of way in a turn; 0: no thread
  double core_diameter = 0;    // m, of the thread; 0 without a thread
  double bore_diameter = 0;    // m, of the thread inside an implant that takes its screw; 0: none
  double bore_depth = 0;       // m
  double speed = 0;            // rad/s that the maker asks for; 0: the tool does not turn
  double top_speed = 0;        // rad/s at full pedal, where the handpiece is geared down for this tool; 0: the motor's
  bool by_hand = false;        // turned by the hand (ratchet), not by the motor
  bool irrigated = false;      // needs cooling
  double greatest_torque = 0;  // N·m the maker allows; 0: none stated
  std::vector<double> marks;   // m above the free end, ascending: the rings of the scale

  bool threaded() const { return pitch > 0; }
  /// Stays in the bone once it is seated.
  bool stays() const { return kind == ImplantToolKind::kImplant || kind == ImplantToolKind::kScrew; }
};

/// Throws Error. `diameter`, `length`: m, of the tool's head.
ImplantTool read_implant_tool(const Json& json, double diameter, double length);

}  // namespace typodont::haptics
