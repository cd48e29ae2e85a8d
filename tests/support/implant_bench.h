// A block of bone and the tools of an implant set, for tests of the contact model "implant".
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/units.h"
#include "haptics/contact_method.h"
#include "haptics/lockstep.h"
#include "haptics/solid.h"
#include "haptics/tool.h"

namespace typodont::test {

using haptics::Tool;

/// Indices of the tools in the order of the set.
enum ImplantTools : std::uint32_t {
  kPilot,
  kTwist28,
  kTwist35,
  kTwist42,
  kGauge22,
  kGauge28,
  kTap,
  kImplant,
  kScrew,
  kRound
};

inline Tool implant_tool(const std::string& name, double diameter_mm, double length_mm, const std::string& block,
                         const char* shape = "cylinder") {
  const std::string length = std::string(shape) == "sphere" ? "" : fmt::format("\"length_mm\": {},", length_mm);
  return haptics::read_tool(
      Json::parse(fmt::format(R"({{"name": "{}", "shape": "{}", "diameter_mm": {}, {} "cuts": {}, "implant": {}}})",
                              name, shape, diameter_mm, length, block.find("gauge") == std::string::npos, block),
                  name));
}
inline std::string drill_block(double centre_mm, double centre = 0, double max_grey = 3500) {
  return fmt::format(
      R"({{"kind": "drill", "ability": {{"end": 1, "centre": {}, "side": 0, "centre_mm": {}}}, "thrust_ratio": 12,
           "greatest_grey_HU": {}, "speed_rpm": 800}})",
      centre, centre_mm, max_grey);
}
inline std::vector<Tool> implant_tools() {
  const char* const thread = R"({{"kind": "{}", "thread": {{"pitch_mm": 0.8, "core_mm": {}}}{}, "top_speed_rpm": 60}})";
  return {implant_tool("pilot", 2.2, 10, drill_block(0, 1)),
          implant_tool("twist 2.8", 2.8, 10, drill_block(2.0)),
          implant_tool("twist 3.5", 3.5, 10, drill_block(2.6)),
          implant_tool("twist 4.2", 4.2, 10, drill_block(3.3)),
          implant_tool("gauge 2.2", 2.2, 10, R"({"kind": "gauge"})"),
          implant_tool("gauge 2.8", 2.8, 10, R"({"kind": "gauge"})"),
          implant_tool("tap", 4.8, 8, fmt::format(fmt::runtime(thread), "tap", 4.2, "")),
          implant_tool(
              "implant", 4.8, 6,
              fmt::format(fmt::runtime(thread), "implant", 4.2, R"(, "bore": {"diameter_mm": 1.8, "depth_mm": 3})")),
          implant_tool("screw", 2.2, 3, fmt::format(fmt::runtime(thread), "screw", 1.8, "")),
          implant_tool("round", 2.3, 0, R"({"kind": "round", "ability": {"end": 1, "side": 1}, "thrust_ratio": 12})",
                       "sphere")};
}

/// Returns a block of bone with a flat top at z = 0: `cortical_mm` of cortical bone, and below it cancellous bone down
/// to `thick_mm`.
inline haptics::TissueVolume bone_block(double cortical_mm = 1.5, double hardness = 0.5, double thick_mm = 12,
                                        double voxel_mm = 0.15) {
  return haptics::TissueVolume(haptics::read_solids(
      Json::parse(fmt::format(R"({{"voxel_mm": {}, "solids": [
        {{"tissue": "cancellous_bone", "hardness": {}, "solid": {{"box": {{"center_mm": [0, 0, {}], "size_mm": [9, 9, {}]}}}}}},
        {{"tissue": "cortical_bone", "solid": {{"box": {{"center_mm": [0, 0, {}], "size_mm": [9, 9, {}]}}}}}}]}})",
                              voxel_mm, hardness, -thick_mm / 2, thick_mm, -cortical_mm / 2, cortical_mm),
                  "bone")));
}

inline haptics::ServoSettings implant_settings(const std::string& model = R"("implant")",
                                               std::vector<Tool> tools = implant_tools()) {
  haptics::ServoSettings s;
  s.tools = std::move(tools);
  s.tool = s.tools.front();
  s.stiffness = 3000;
  s.damping = 0;
  s.passivity = false;  // these hands jump after the tool, and an energy ledger would reduce the force
  s.torque_limit = 2;
  s.spindle.free_speed = 0.8 * kKrpm;
  for (Material& m : s.materials) m.stiffness = 1000, m.specific_energy = 0.1e9;
  s.materials[static_cast<std::size_t>(Tissue::kCorticalBone)].specific_energy = 0.5e9;
  s.method = haptics::read_contact_method(Json::parse(model, "model"));
  return s;
}

/// Servo and carver in lock-step, with a hand that knows the tool's pose.
struct ImplantSession {
  haptics::LockStep steps;
  ServoTick tick;
  Cut cut;
  Nanos t = 0;
  std::uint32_t tool = 0;
  double stiffness, period;  // N/m, s
  std::vector<Tool> tools;

  explicit ImplantSession(haptics::TissueVolume tissue = bone_block(),
                          const haptics::ServoSettings& s = implant_settings())
      : steps(std::move(tissue), s), stiffness(s.stiffness), period(s.tick), tools(s.tools) {}

  double half() const { return tools[tool].half(); }
  /// Returns the depth (m) of the proxy's tip below the bone's top.
  double depth() const { return -(tick.X_WG * dvec3(0, 0, -half())).z; }
  bool step(const Pose& X_WT, double pedal = 0) {
    haptics::HandSample hand;
    hand.t = t += from_seconds(period);
    hand.X_WT = X_WT;
    hand.pedal = pedal;
    hand.tool = tool;
    return steps.tick(hand, tick, cut);
  }
  /// Moves the tip of the hand's tool to `p_mm` (mm), upright or with rotation R.
  bool tip_at(const dvec3& p_mm, double pedal = 0, const dquat& R = {1, 0, 0, 0}) {
    return step({p_mm * kMillimetre + R * dvec3(0, 0, half()), R}, pedal);
  }
  /// Pushes the tool straight down with about this force: the hand's tool lies newton / stiffness below the proxy.
  bool push(double newton, double pedal = 0) {
    return step({tick.X_WG.p - dvec3(0, 0, newton / stiffness), {1, 0, 0, 0}}, pedal);
  }
  /// Takes a tool above the middle of the block.
  void take(std::uint32_t which) {
    tool = which;
    for (int i = 0; i < 600 && (i < 20 || tick.tool != which); ++i) tip_at({0, 0, 8});
  }
  /// Takes this tool and lowers it onto the bone.
  void land_with(std::uint32_t which) {
    take(which);
    land();
  }
  /// Lowers the tool onto the bone.
  void land(double x_mm = 0, double y_mm = 0) {
    for (int i = 0; i <= 400; ++i) tip_at({x_mm, y_mm, 3.0 - 3.0 * i / 400});
  }
  /// Drills until the tip is `mm` deep. The hand pushes with `newton`. Returns false if the tip does not get there.
  bool drill(double mm, double newton = 3, int most = 60000) {
    for (int i = 0; i < most && depth() < mm * kMillimetre; ++i) {
      // Near the end the hand pushes with less force, so that the tip does not go deeper than `mm`.
      const double left = mm * kMillimetre - depth();
      step({tick.X_WG.p - dvec3(0, 0, std::min(newton / stiffness, left + 1e-6)), {1, 0, 0, 0}}, 1);
    }
    return depth() >= mm * kMillimetre - 2e-6;
  }
  /// Withdraws the tool upwards at 20 mm/s.
  void withdraw() {
    const double from = -depth() / kMillimetre;
    for (double z = from; z < 8; z += 0.02) tip_at({0, 0, z});
    for (int i = 0; i < 300; ++i) tip_at({0, 0, 8});
  }
  double removed_mm3() const { return total(tick.removed) / kCubicMillimetre; }
};

}  // namespace typodont::test
