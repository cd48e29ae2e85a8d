// Simulated hands push every rotary tool of the catalogue into the molar, with caries, by a constant force. They come
// down from the air at up to 0.1 m/s, land, drill, and slip off edges. At 1 kHz the force on the hand must not change
// by 0.02 N or more from one tick to the next, the landing included. Only where the coupling has given way by more than
// 3 N, at a hard landing, may it change faster, and by no more than the law says. ./run stress runs more hands.
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

/// N by which the force may change in a tick where the coupling gives the hand so many N less than it holds.
double most_step(double given_way) {
  return 0.02 + 0.0185 * 8 * std::max(0.0, given_way - 3);
}

/// What a hand felt in 2.5 s.
struct Felt {
  std::string hand;
  bool landed = false;
  double step = 0, most = 1;  // N, a change from tick to tick and what it may be: those that are closest to it, …
  double at = 0, speed = 0;   // … and s and m/s of the hand there
  double energy = 0;          // J, the least in the ledger
};

Felt push(const std::string& tool, const std::string& spindle, std::uint32_t seed,
          const haptics::TissueVolume& tissue) {
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
  Felt felt;
  felt.hand = fmt::format("{} {} seed {}: push {:.3f} N, tilt {:.3f}, {:.1f} mm/s, from {:.2f} {:.2f} {:.2f} mm", tool,
                          spindle, seed, push, tilt, speed * 1e3, start.x * 1e3, start.y * 1e3, start.z * 1e3);
  const auto hand = haptics::make_simulated_hand(path, model, 1000, false);
  HapticLoop loop(scene, tissue.clone(), hand->info());
  ServoTick last;
  loop.run(*hand, [&](const ServoTick& tick, const Cut*) {
    const double step = glm::length(tick.f_T_W - last.f_T_W),
                 most = most_step(glm::length(last.f_model_W - last.f_T_W));
    if (tick.index > 0 && step / most > felt.step / felt.most) {
      felt.step = step, felt.most = most;
      felt.at = to_seconds(tick.t), felt.speed = glm::length(tick.X_WT.p - last.X_WT.p) / 1e-3;
    }
    felt.landed |= tick.depth > 0;
    felt.energy = std::min(felt.energy, tick.energy);
    last = tick;
  });
  return felt;
}

TEST(ConstantPush, OfAnyRotaryToolGivesNoStepAlsoWhereItLandsUnlessTheCouplingGaveWayByThreeNewtons) {
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
  const int hands = test::campaign(24);
  int landed = 0;
  for (int i = 0; i < hands; ++i) {
    const std::string& tool = tools[static_cast<std::size_t>(i * 7) % tools.size()];
    const Felt felt = push(tool, i % 2 ? "air_turbine" : "electric_1_5", static_cast<std::uint32_t>(i), tissue);
    landed += felt.landed;
    EXPECT_LT(felt.step, felt.most) << felt.hand << ", at " << felt.at << " s, the hand at " << 1e3 * felt.speed
                                    << " mm/s";
    EXPECT_GE(felt.energy, -1e-9) << felt.hand;
  }
  EXPECT_GT(landed, 0.9 * hands);
}

}  // namespace
}  // namespace typodont
