// What the C interface costs: a tick through it beside the same tick of the core, taken in turns in one run.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <typodont.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "engine/app/offline.h"
#include "engine/base/clock.h"

namespace typodont {
namespace {

constexpr const char* kBall = R"({"tissue": {"voxel_mm": 0.1, "solids": [
  {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": "round_012", "spindle_krpm": 300})";
constexpr int kTicks = 500, kRounds = 400;

/// What else the machine does only adds to a round's time: the fastest is nearest to what a tick costs by itself.
double fastest(const std::vector<double>& rounds) {
  return *std::min_element(rounds.begin(), rounds.end());
}

/// ns a tick on top, where the hand moves about z metres above the ball's centre.
double on_top(double z) {
  const Scene scene = parse_scene(Json::parse(kBall, "ball"), "ball.json");
  haptics::DeviceInfo hand;
  hand.torque_limit = 1;
  haptics::LockStep steps = load_lock_step(scene, hand);
  typodont_scene* c_scene = nullptr;
  typodont_core* core = nullptr;
  EXPECT_EQ(typodont_scene_parse(kBall, nullptr, nullptr, &c_scene), TYPODONT_OK) << typodont_error();
  EXPECT_EQ(typodont_core_new(c_scene, nullptr, nullptr, &core), TYPODONT_OK) << typodont_error();
  const auto place = [&](Nanos t) { return dvec3(1e-7 * static_cast<double>(t % 1000), 0, z); };
  ServoTick tick;
  Cut cut;
  typodont_tick c_tick{};
  c_tick.struct_size = sizeof c_tick;
  std::vector<double> own, through;
  Nanos t = 0, c_t = 0;
  for (int round = 0; round < kRounds; ++round) {
    Nanos start = now();
    for (int i = 0; i < kTicks; ++i, ++t) {
      haptics::HandSample sample;
      sample.t = t * 1'000'000;
      sample.X_WT.p = place(t);
      steps.tick(sample, tick, cut);
    }
    own.push_back(static_cast<double>(now() - start) / kTicks);
    start = now();
    for (int i = 0; i < kTicks; ++i, ++c_t) {
      typodont_sample sample{};
      sample.struct_size = sizeof sample;
      sample.t_ns = c_t * 1'000'000;
      const dvec3 p = place(c_t);
      sample.X_WT = {{p.x, p.y, p.z}, {1, 0, 0, 0}};
      EXPECT_EQ(typodont_core_tick(core, &sample, &c_tick, nullptr), TYPODONT_OK);
    }
    through.push_back(static_cast<double>(now() - start) / kTicks);
  }
  EXPECT_EQ(tick.f_T_W.z, c_tick.force[2]);
  EXPECT_EQ(typodont_core_free(core), TYPODONT_OK);
  EXPECT_EQ(typodont_scene_free(c_scene), TYPODONT_OK);
  const double more = fastest(through) - fastest(own);
  fmt::print("{:.1f} mm: core {:.1f} ns, through C {:.1f} ns, on top {:.1f} ns\n", z * 1e3, fastest(own),
             fastest(through), more);
  return more;
}

TEST(DoorsBench, ATickThroughTheCInterfaceTakesAtMost20NanosecondsMoreInTheAir) {
  EXPECT_LE(on_top(4e-3), 20);
}

TEST(DoorsBench, ATickThroughTheCInterfaceTakesAtMost20NanosecondsMoreInContact) {
  EXPECT_LE(on_top(3.5e-3), 20);
}

}  // namespace
}  // namespace typodont
