#include "haptics/implant_tool.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "engine/base/units.h"

namespace typodont::haptics {

namespace {

constexpr std::array<std::pair<ImplantToolKind, std::string_view>, 6> kKinds = {{
    {ImplantToolKind::kRound, "round"},
    {ImplantToolKind::kDrill, "drill"},
    {ImplantToolKind::kGauge, "gauge"},
    {ImplantToolKind::kTap, "tap"},
    {ImplantToolKind::kImplant, "implant"},
    {ImplantToolKind::kScrew, "screw"},
}};
constexpr double kRpm = 2 * kPi / 60;       // rad/s, one revolution per minute
constexpr double kNewtonCentimetre = 1e-2;  // N·m, one newton centimetre
constexpr double kMaxGrey = 1e5;            // Hounsfield units, largest value that a file may state
// rpm, largest value that a file may state; far above real motors
constexpr double kMaxSpeed = 5000;

}  // namespace

std::string_view name_of(ImplantToolKind kind) noexcept {
  return kKinds[static_cast<std::size_t>(kind)].second;
}

ImplantTool read_implant_tool(const Json& json, double diameter, double length) {
  json.allow_only({"kind", "ability", "greatest_grey_HU", "thrust_ratio", "thread", "bore", "speed_rpm",
                   "top_speed_rpm", "by_hand", "irrigated", "greatest_torque_Ncm", "marks_mm", "source"});
  ImplantTool tool;
  const std::string kind = json["kind"].string();
  const auto found = std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& k) { return k.second == kind; });
  if (found == kKinds.end()) json["kind"].fail("round, drill, gauge, tap, implant or screw");
  tool.kind = found->first;
  if (const auto ability = json.find("ability")) {
    ability->allow_only({"end", "centre", "side", "centre_mm"});
    tool.end_ability = ability->number_or("end", 0, 0, 1);
    tool.centre_ability = ability->number_or("centre", tool.end_ability, 0, 1);
    tool.side_ability = ability->number_or("side", 0, 0, 1);
    tool.centre_radius = ability->number_or("centre_mm", 0, 0, diameter / kMillimetre) / 2 * kMillimetre;
  }
  const bool drills = tool.end_ability > 0 || tool.side_ability > 0;
  if (drills && tool.kind == ImplantToolKind::kGauge) json["ability"].fail("none for a gauge: it only measures");
  if (!drills && (tool.kind == ImplantToolKind::kDrill || tool.kind == ImplantToolKind::kRound))
    json.fail("no ability to cut", "\"ability\" above 0 for a drill or a round bur");
  tool.max_grey = json.number_or("greatest_grey_HU", kMaxGrey, 0, kMaxGrey);
  tool.thrust_ratio = json.number_or("thrust_ratio", 1, 0.01, 1000);
  if (const auto thread = json.find("thread")) {
    thread->allow_only({"pitch_mm", "core_mm"});
    tool.pitch = (*thread)["pitch_mm"].number(0.05, 5) * kMillimetre;
    tool.core_diameter = (*thread)["core_mm"].number(0.2, diameter / kMillimetre) * kMillimetre;
  }
  const bool needs_thread = tool.kind == ImplantToolKind::kTap || tool.stays();
  if (needs_thread != tool.threaded()) {
    json.fail(needs_thread ? "no \"thread\"" : "a \"thread\"",
              needs_thread ? fmt::format("a thread for a {}", kind) : fmt::format("no thread for a {}", kind));
  }
  if (const auto bore = json.find("bore")) {
    bore->allow_only({"diameter_mm", "depth_mm"});
    if (tool.kind != ImplantToolKind::kImplant) json["bore"].fail("none but in an implant");
    tool.bore_diameter = (*bore)["diameter_mm"].number(0.2, diameter / kMillimetre) * kMillimetre;
    tool.bore_depth = (*bore)["depth_mm"].number(0.5, length / kMillimetre) * kMillimetre;
  }
  tool.speed = json.number_or("speed_rpm", 0, 0, kMaxSpeed) * kRpm;
  tool.top_speed = json.number_or("top_speed_rpm", 0, 0, kMaxSpeed) * kRpm;
  if (tool.top_speed > 0 && tool.top_speed < tool.speed) json["top_speed_rpm"].fail("at least speed_rpm");
  tool.by_hand = json.boolean_or("by_hand", false);
  if (tool.by_hand && !tool.threaded()) json["by_hand"].fail("false for a tool without a thread");
  tool.irrigated = json.boolean_or("irrigated", false);
  tool.max_torque = json.number_or("greatest_torque_Ncm", 0, 0, 500) * kNewtonCentimetre;
  if (const auto marks = json.find("marks_mm")) {
    double last = 0;
    for (const Json& mark : marks->items()) {
      const double at = mark.number(0.1, 60);
      if (!(at > last)) mark.fail("marks in ascending order");
      if (at * kMillimetre > length + 1e-9) mark.fail("marks on the head, no farther up than length_mm");
      tool.marks.push_back(at * kMillimetre);
      last = at;
    }
  }
  return tool;
}

}  // namespace typodont::haptics
