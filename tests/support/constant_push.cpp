#include "tests/support/constant_push.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "engine/app/assets.h"
#include "engine/app/recording/resume.h"
#include "engine/app/stepped.h"
#include "engine/base/units.h"

namespace typodont::test {

namespace {

using namespace literals;

constexpr const char* kTissue = R"("tissue": {"volume": "teeth/molar.vdb"}, "paint": [
  {"tissue": "caries", "solid": {"capsule": {"a_mm": [6.7, 5.8, 19.0], "b_mm": [6.8, 5.8, 16.4], "radius_mm": 0.75}}},
  {"tissue": "caries", "solid": {"sphere": {"center_mm": [6.8, 5.8, 16.5], "radius_mm": 1.15}}},
  {"tissue": "caries", "solid": {"capsule": {"a_mm": [6.6, 5.1, 18.8], "b_mm": [6.75, 6.5, 18.9], "radius_mm": 0.6}}}])";
constexpr double kRate = 1000;  // Hz, rate of the servo
// N/m, limit for a force step: the stiffness of the coupling spring (1 N/mm) plus 10 %. From one tick to the next, the
// force may change by this stiffness times the distance that the hand moved. A larger change counts as a step.
constexpr double kSpring = 1.1 * 1000;
constexpr double kSeconds = 2.5;  // s, duration of the motion of a hand from random_push()
// number of ticks; a contact is a new touch only if more than this number of ticks without contact came before it
constexpr std::size_t kFreeTicks = 30;

Scene push_scene(const std::string& tool, const std::string& spindle) {
  return parse_scene(Json::parse(fmt::format(R"({{"name": "push", {}, "tool": "{}"{}, "parts": ["haptics"]}})", kTissue,
                                             tool, spindle.empty() ? "" : fmt::format(R"(, "spindle": "{}")", spindle)),
                                 "scene"),
                     "scene.json");
}

void see(PushSteps& steps, const ForceStep& step) {
  if (step.size > steps.largest.size) steps.largest = step;
  const double over = step.size - std::max(kPushStep, kSpring * step.speed / kRate);
  if (over > steps.over) steps.over = over, steps.beyond_spring = step;
}

}  // namespace

std::vector<std::string> tools_of(ToolKind kind) {
  std::vector<std::string> tools;
  for (const auto& entry : std::filesystem::directory_iterator(assets_folder() / "tools")) {
    if (entry.path().extension() != ".json") continue;
    const haptics::Tool tool = haptics::read_tool(Json::load(entry.path()));
    const ToolKind its = tool.turns() ? ToolKind::kTurns : tool.scrapes > 0 ? ToolKind::kScrapes : ToolKind::kTouches;
    if (its == kind) tools.push_back(entry.path().stem().string());
  }
  std::sort(tools.begin(), tools.end());
  return tools;
}

PushHand random_push(const std::vector<std::string>& tools, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto in = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  PushHand hand;
  hand.tool = tools[std::size_t{seed} * 7 % tools.size()];
  const haptics::Tool tool = push_scene(hand.tool, "").servo.tool;
  if (tool.turns()) hand.spindle = seed % 2 ? "air_turbine" : "electric_1_5";
  hand.push = tool.turns() ? in(0.2, 0.8) : in(1, 4);
  const double tilt = in(0, 0.5), about = in(0, 2 * kPi), speed = in(0, 8e-3), way = in(0, 2 * kPi);
  const double x = in(5.5_mm, 8.0_mm), y = in(4.7_mm, 6.7_mm);
  const dvec3 start(x, y, 19.6_mm + tool.reach() + in(0.2_mm, 4.0_mm));
  for (int i = 0; i <= 250; ++i) {
    haptics::HandPath::Row row;
    row.t = kSeconds * i / 250;
    row.X_WT.p = start + speed * row.t * dvec3(std::cos(way), std::sin(way), 0);
    row.X_WT.R = glm::angleAxis(tilt, dvec3(std::cos(about), std::sin(about), 0));
    row.pedal = 1;
    hand.path.rows.push_back(row);
  }
  return hand;
}

haptics::TissueVolume pushed_tissue() {
  return load_tissue(push_scene("round_012", "air_turbine"));
}

std::string text_of(const PushHand& hand) {
  const dvec3 start = 1e3 * hand.path.rows.front().X_WT.p;
  return fmt::format("{} {}, push {:.3f} N, from {:.2f} {:.2f} {:.2f} mm", hand.tool, hand.spindle, hand.push, start.x,
                     start.y, start.z);
}

PushResult simulate_push(const PushHand& hand, const haptics::TissueVolume& tissue) {
  haptics::HandModel model;
  model.mass = 0.15, model.damping = 5, model.stiffness = {2000, 2000, 0};
  model.push = {0, 0, -hand.push};
  const auto device = haptics::make_simulated_hand(hand.path, model, kRate, false);
  const Scene scene = push_scene(hand.tool, hand.spindle);
  SteppedSession session(scene, tissue.clone(), device->info());
  PushResult result;
  ServoTick last;
  std::size_t free_for = 1000, since_touch = 1000;
  while (session.advance(*device)) {
    const ServoTick& tick = session.last();
    const bool touches = tick.depth > 0, touched = last.depth > 0;
    since_touch = touches && !touched && free_for > kFreeTicks ? 0 : since_touch + 1;
    free_for = touches ? 0 : free_for + 1;
    if (to_seconds(tick.t) < 5e-3 && (tick.faults & bits(Fault::kDeepPenetration)) != 0) result.begins_inside = true;
    if (tick.index > 0) {
      const ForceStep step{glm::length(tick.f_T_W - last.f_T_W), to_seconds(tick.t),
                           glm::length(tick.X_WT.p - last.X_WT.p) * kRate};
      see(result.any, step);
      if (static_cast<double>(since_touch) > kRate * kPushLanding) see(result.after_landing, step);
    }
    result.min_energy = std::min(result.min_energy, tick.energy);
    result.faults |= tick.faults;
    last = tick;
  }
  return result;
}

}  // namespace typodont::test
