// Hands that push every shipped rotary tool with a constant force into the molar, with caries. Once a hand has landed,
// the force on it changes from tick to tick, at 1 kHz, by less than 0.02 N, or than the coupling's spring gives by the
// hand's own way in that tick (where it slips off an edge). ./run stress makes it long.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "engine/app/haptic_loop.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/base/units.h"
#include "haptics/scripted_hand.h"
#include "tests/support/campaign.h"

namespace typodont {
namespace {

using namespace literals;

constexpr const char* kTissue = R"("tissue": {"volume": "teeth/molar.vdb"}, "paint": [
  {"tissue": "caries", "solid": {"capsule": {"a_mm": [6.7, 5.8, 19.0], "b_mm": [6.8, 5.8, 16.4], "radius_mm": 0.75}}},
  {"tissue": "caries", "solid": {"sphere": {"center_mm": [6.8, 5.8, 16.5], "radius_mm": 1.15}}},
  {"tissue": "caries", "solid": {"capsule": {"a_mm": [6.6, 5.1, 18.8], "b_mm": [6.75, 6.5, 18.9], "radius_mm": 0.6}}}])";

constexpr double kLanding = 0.3;  // s after a touch: the hand comes at up to 0.1 m/s, and bounces

/// A change of the force from tick to tick.
struct Step {
  double size = 0, t = 0;  // N, s
  double speed = 0;        // m/s, of the hand
};

/// The step that exceeds 0.02 N, and what the hand's own way gives, by most; its size is 0 where none does.
Step worst_step(const std::string& tool, const std::string& spindle, std::uint32_t seed,
                const haptics::TissueVolume& tissue, std::string& hand_was) {
  std::mt19937 random(seed);
  const auto in = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const Scene scene = parse_scene(
      Json::parse(fmt::format(R"({{"name": "push", {}, "tool": "{}", "spindle": "{}", "parts": ["haptics"]}})", kTissue,
                              tool, spindle),
                  "scene"),
      "scene.json");
  haptics::HandModel model;
  model.mass = 0.15, model.damping = 5, model.stiffness = {2000, 2000, 0};
  const double push = in(0.2, 0.8), tilt = in(0, 0.5), about = in(0, 2 * kPi), speed = in(0, 8e-3),
               way = in(0, 2 * kPi);
  model.push = {0, 0, -push};
  const double reach = scene.servo.tool.reach();
  const dvec3 start(in(5.5_mm, 8.0_mm), in(4.7_mm, 6.7_mm), 19.6_mm + reach + in(0.2_mm, 4.0_mm));
  haptics::HandPath path;
  for (int i = 0; i <= 250; ++i) {
    haptics::HandPath::Row row;
    row.t = 0.01 * i;
    row.X_WT.p = start + speed * row.t * dvec3(std::cos(way), std::sin(way), 0);
    row.X_WT.R = glm::angleAxis(tilt, dvec3(std::cos(about), std::sin(about), 0));
    row.pedal = 1;
    path.rows.push_back(row);
  }
  hand_was = fmt::format("{} {} seed {}: push {:.3f} N, tilt {:.3f}, {:.1f} mm/s, from {:.2f} {:.2f} {:.2f} mm", tool,
                         spindle, seed, push, tilt, speed * 1e3, start.x * 1e3, start.y * 1e3, start.z * 1e3);
  const auto hand = haptics::make_simulated_hand(path, model, 1000, false);
  HapticLoop loop(scene, tissue.clone(), hand->info());
  Step worst;
  double most = 0;
  ServoTick last;
  int free_for = 1000, since_touch = 1000;
  loop.run(*hand, [&](const ServoTick& tick, const Cut*) {
    free_for = tick.depth > 0 ? 0 : free_for + 1;
    since_touch = tick.depth > 0 && last.depth == 0 && free_for == 0 && since_touch > 30 ? 0 : since_touch + 1;
    const double moved = glm::length(tick.X_WT.p - last.X_WT.p), size = glm::length(tick.f_T_W - last.f_T_W);
    const double over = size - std::max(0.02, 1.1 * 1000 * moved);  // N: a spring of 1 N/mm
    if (tick.index > 0 && since_touch > 1e3 * kLanding && over > most) {
      most = over;
      worst = {size, to_seconds(tick.t), moved / 1e-3};
    }
    last = tick;
  });
  return worst;
}

TEST(ConstantPush, AnyRotaryToolGivesNoForceStepBeyondThatOfTheHandsMotion) {
  std::vector<std::string> tools;
  for (const auto& entry : std::filesystem::directory_iterator("assets/tools")) {
    if (entry.path().extension() != ".json") continue;
    if (haptics::read_tool(Json::load(entry.path())).turns()) tools.push_back(entry.path().stem().string());
  }
  std::sort(tools.begin(), tools.end());
  const Scene scene = parse_scene(
      Json::parse(fmt::format(R"({{"name": "push", {}, "tool": "round_012", "parts": ["haptics"]}})", kTissue),
                  "scene"),
      "scene.json");
  const haptics::TissueVolume tissue = load_tissue(scene);
  for (int i = 0; i < test::campaign(24); ++i) {
    const std::string& tool = tools[static_cast<std::size_t>(i * 7) % tools.size()];
    std::string hand;
    const Step worst =
        worst_step(tool, i % 2 ? "air_turbine" : "electric_1_5", static_cast<std::uint32_t>(i), tissue, hand);
    EXPECT_EQ(worst.size, 0) << hand << ", at " << worst.t << " s, the hand at " << 1e3 * worst.speed << " mm/s";
  }
}

}  // namespace
}  // namespace typodont
