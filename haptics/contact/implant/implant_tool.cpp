#include <fmt/format.h>

#include <array>
#include <limits>

#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "haptics/described.h"
#include "haptics/tool.h"

namespace typodont::haptics {

namespace {

constexpr std::array<std::string_view, 6> kKinds = {"round", "drill", "gauge", "tap", "implant", "screw"};
constexpr double kRpm = 2 * kPi / 60;       // rad/s, one revolution per minute
constexpr double kNewtonCentimetre = 1e-2;  // N·m, one newton centimetre
constexpr double kMaxGrey = 1e5;            // Hounsfield units, largest value that a file may state
// rpm, largest value that a file may state; far above real motors
constexpr double kMaxSpeed = 5000;

}  // namespace

std::string_view name_of(ImplantToolKind kind) noexcept {
  return kKinds[static_cast<std::size_t>(kind)];
}

void describe_implant_tool(Keys& keys, ImplantTool& tool, double diameter, double length) {
  const Json* json = keys.json();
  constexpr double kAny = std::numeric_limits<double>::infinity();
  const double max_width = json ? diameter / kMillimetre : kAny, max_depth = json ? length / kMillimetre : kAny;
  keys(must("kind"), tool.kind, kKinds, "kind of instrument");
  const auto ability = [&](Keys& of) {
    of("end", tool.end_ability, {0, 1}, "ability to cut at the end");
    tool.centre_ability = json ? tool.end_ability : kNoDefault;
    of("centre", tool.centre_ability, {0, 1}, "ability at the centre of the end; default: as `end`");
    of("side", tool.side_ability, {0, 1}, "ability at the side");
    of("centre_mm", tool.centre_radius, {0, max_width, kMillimetre / 2},
       "diameter of the centre; at most that of the head");
  };
  keys("ability", ability, "ability to cut; above 0 at end or side of `round` and `drill`, none for a gauge");
  const bool drills = tool.end_ability > 0 || tool.side_ability > 0;
  if (json && drills && tool.kind == ImplantToolKind::kGauge)
    (*json)["ability"].fail("none for a gauge: it only measures");
  if (json && !drills && (tool.kind == ImplantToolKind::kDrill || tool.kind == ImplantToolKind::kRound))
    json->fail("no ability to cut", "\"ability\" above 0 for a drill or a round bur");
  tool.max_grey = kMaxGrey;
  keys("greatest_grey_HU", tool.max_grey, {0, kMaxGrey}, "largest grey value of bone that the tool can cut");
  keys("thrust_ratio", tool.thrust_ratio, {0.01, 1000}, "ratio of tangential to normal force");
  const auto thread = [&](Keys& of) {
    of(must("pitch_mm"), tool.pitch, {0.05, 5, kMillimetre}, "pitch");
    of(must("core_mm"), tool.core_diameter, {0.2, max_width, kMillimetre}, "core diameter; at most that of the head");
  };
  keys("thread", thread, "thread. Required for a tap, an implant and a screw; not allowed for other kinds");
  const bool needs_thread = tool.kind == ImplantToolKind::kTap || tool.stays();
  if (json && needs_thread != tool.threaded()) {
    const std::string_view kind = name_of(tool.kind);
    json->fail(needs_thread ? "no \"thread\"" : "a \"thread\"",
               needs_thread ? fmt::format("a thread for a {}", kind) : fmt::format("no thread for a {}", kind));
  }
  const auto bore = [&](Keys& of) {
    of(must("diameter_mm"), tool.bore_diameter, {0.2, max_width, kMillimetre}, "diameter; at most that of the head");
    of(must("depth_mm"), tool.bore_depth, {0.5, max_depth, kMillimetre}, "depth; at most the length of the head");
  };
  keys("bore", bore, "inner thread of an implant for its screw; only for an implant");
  if (json && tool.bore_diameter > 0 && tool.kind != ImplantToolKind::kImplant)
    (*json)["bore"].fail("none but in an implant");
  keys("speed_rpm", tool.speed, {0, kMaxSpeed, kRpm}, "usual speed; 0: the tool does not rotate");
  keys("top_speed_rpm", tool.top_speed, {0, kMaxSpeed, kRpm},
       "speed at full pedal, at least `speed_rpm`; 0: that of the motor");
  if (json && tool.top_speed > 0 && tool.top_speed < tool.speed) (*json)["top_speed_rpm"].fail("at least speed_rpm");
  keys("by_hand", tool.by_hand, "true: the user turns the tool by hand; only for a tool with a thread");
  if (json && tool.by_hand && !tool.threaded()) (*json)["by_hand"].fail("false for a tool without a thread");
  keys("irrigated", tool.irrigated, "true: the tool needs cooling water");
  keys("greatest_torque_Ncm", tool.max_torque, {0, 500, kNewtonCentimetre}, "largest permitted torque; 0: not stated");
  if (const auto marks =
          keys("marks_mm", kNumbers,
               "ascending list, each 0.1–60 and at most `length_mm`: heights of the depth marks above the free end")) {
    double last = 0;
    for (const Json& mark : marks->items()) {
      const double at = mark.number(0.1, 60);
      if (!(at > last)) mark.fail("marks in ascending order");
      if (at * kMillimetre > length + 1e-9) mark.fail("marks on the head, no farther up than length_mm");
      tool.marks.push_back(at * kMillimetre);
      last = at;
    }
  }
  keys.ignore("source");
}

dvec3 read_direction_into_bone(const Json& json) {
  const dvec3 axis = json.vec3();
  if (!(glm::length(axis) > 1e-9)) json.fail("a direction into the bone, not zero");
  return glm::normalize(axis);
}

ImplantTool read_implant_tool(const Json& json, double diameter, double length) {
  ImplantTool tool;
  read_keys(json, [&](Keys& keys) { describe_implant_tool(keys, tool, diameter, length); });
  return tool;
}

}  // namespace typodont::haptics
