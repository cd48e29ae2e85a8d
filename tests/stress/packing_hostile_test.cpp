// Hands no human has among spheres: what goes out is finite and bounded, nothing comes through a wall, and no hand gets
// energy from nothing. Short here; ./run stress makes ten million ticks of it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "engine/base/units.h"
#include "haptics/contact_method.h"
#include "tests/support/campaign.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::ServoSettings;
using test::campaign;
using test::HapticBench;

constexpr double kForceLimit = 8, kTorqueLimit = 0.5;  // N, N·m
constexpr int kRound = 4000;                           // ticks until the tissue is made anew

struct Body {
  const char* name;
  const char* tissue;
  double top;  // m: no tissue is higher
};
constexpr Body kBodies[] = {
    {"a bored ball of two tissues",
     R"({"voxel_mm": 0.2, "solids": [
      {"tissue": "enamel", "solid": {"difference": [{"sphere": {"radius_mm": 3}}, {"cylinder": {"radius_mm": 0.8, "height_mm": 20}}]}},
      {"tissue": "dentin", "solid": {"difference": [{"sphere": {"radius_mm": 2}}, {"cylinder": {"radius_mm": 0.8, "height_mm": 20}}]}}]})",
     3.0_mm},
    {"a sheet of 0.3 mm",
     R"({"voxel_mm": 0.1, "band_mm": 0.8, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [5, 5, 0.3]}}}]})",
     0.15_mm},
    {"a V-groove of 40 degrees",
     R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"difference": [
      {"box": {"size_mm": [4, 4, 3]}}, {"intersection": [{"box": {"size_mm": [6, 6, 6]}},
      {"halfspace": {"normal": [0.94, 0, -0.342], "offset_mm": 0}}, {"halfspace": {"normal": [-0.94, 0, -0.342], "offset_mm": 0}}]}]}}]})",
     1.5_mm},
    {"two balls that touch",
     R"({"voxel_mm": 0.1, "solids": [
      {"tissue": "enamel", "solid": {"sphere": {"center_mm": [-1.5, 0, 0], "radius_mm": 1.5}}},
      {"tissue": "dentin", "solid": {"sphere": {"center_mm": [1.5, 0, 0], "radius_mm": 1.5}}}]})",
     1.5_mm}};

/// A hand that is pushed about with up to 20 m/s² at up to 0.2 m/s, and turns the tool meanwhile.
class Wanderer {
 public:
  Wanderer(std::uint64_t seed, dvec3 home) : random_(seed), home_(home), p_(home) {}
  Pose next(double dt) {
    if (random_() % 400 == 0) {
      constexpr double kSpeeds[] = {0.01, 0.03, 0.1, 0.2};  // m/s
      speed_ = kSpeeds[random_() % 4];
    }
    v_ += std::sqrt(dt) * 3.0 * speed_ * anywhere() - dt * (6.0 * v_ + 60.0 * (p_ - home_));
    if (const double length = glm::length(v_); length > speed_) v_ *= speed_ / length;
    turn_ += std::sqrt(dt) * 10.0 * anywhere() - dt * 4.0 * turn_;  // rad/s
    if (const double rate = glm::length(turn_); rate > 0) {
      R_ = glm::normalize(glm::angleAxis(rate * dt, turn_ / rate) * R_);
    }
    p_ += dt * v_;
    return {p_, R_};
  }
  void leap_to(const dvec3& p) { p_ = p; }

 private:
  dvec3 anywhere() {
    const double x = normal_(random_), y = normal_(random_), z = normal_(random_);
    return {x, y, z};
  }
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_{0, 1};
  double speed_ = 0.03;
  dvec3 home_, p_, v_{0}, turn_{0};
  dquat R_{1, 0, 0, 0};
};

class HostileHandAmongSpheres : public testing::TestWithParam<const char*> {
 protected:
  static ServoSettings settings() {
    ServoSettings s;
    s.tool = haptics::read_tool(Json::load(fmt::format("assets/tools/{}.json", GetParam())));
    s.spindle.free_speed = 300.0_krpm;
    s.force_limit = kForceLimit;
    s.torque_limit = kTorqueLimit;
    s.method = haptics::read_contact_method(Json::parse(R"({"packing": {"spheres": 2000, "tool_spheres": 30}})", "t"));
    return s;
  }
  static void expect_sense(const ServoTick& tick) {
    ASSERT_TRUE(is_finite(tick.f_T_W) && is_finite(tick.tau_T_W) && is_finite(tick.X_WG.p));
    ASSERT_TRUE(std::isfinite(tick.energy) && std::isfinite(tick.depth) && std::isfinite(tick.contact_area));
    ASSERT_LE(glm::length(tick.f_T_W), kForceLimit * (1 + 1e-9));
    ASSERT_LE(glm::length(tick.tau_T_W), kTorqueLimit * (1 + 1e-9));
  }
};

TEST_P(HostileHandAmongSpheres, GetsNoEnergyFromNothingAndComesThroughNoWall) {
  std::uint64_t seed = 1;
  double felt = 0;
  for (const Body& body : kBodies) {
    for (int left = campaign(4200); left > 0; left -= kRound, ++seed) {
      SCOPED_TRACE(fmt::format("{}, seed {}", body.name, seed));
      const ServoSettings s = settings();
      HapticBench bench(body.tissue, s);
      Wanderer hand(seed, {0, 0, body.top + haptics::near_reach(s.tool) + 0.2_mm});  // not born inside
      const bool drills = seed % 3 != 0, sheet = body.top < 0.2_mm;
      double work = 0;  // J, of the spindle
      for (int i = 0; i < std::min(left, kRound); ++i) {
        const Pose at = hand.next(1e-3);
        dvec3 p = at.p - dvec3(0, 0, 1.5_mm * (1 - std::cos(2e-3 * kPi * i)));
        if (sheet) p = glm::clamp(p, dvec3(-1.0_mm, -1.0_mm, -1), dvec3(1.0_mm, 1.0_mm, 1));
        const ServoTick& tick = bench.tick({p, at.R}, drills ? 1 : 0);
        ASSERT_NO_FATAL_FAILURE(expect_sense(tick)) << "tick " << i;
        ASSERT_GE(tick.energy, -1e-9) << "tick " << i;
        work += tick.cutting_power * 1e-3;
        ASSERT_LE(tick.spindle_energy, work + 1e-7) << "tick " << i;
        if (sheet && !drills) {
          ASSERT_GT(tick.X_WG.p.z, 0) << "tick " << i;
        }
        felt = std::max(felt, glm::length(tick.f_T_W));
      }
    }
  }
  EXPECT_GT(felt, 0.1);
}

TEST_P(HostileHandAmongSpheres, NeverGetsNonsenseForNonsense) {
  std::uint64_t seed = 1;
  int bad = 0, all = 0;
  for (const Body& body : kBodies) {
    for (int left = campaign(4200); left > 0; left -= kRound, ++seed) {
      SCOPED_TRACE(fmt::format("{}, seed {}", body.name, seed));
      HapticBench bench(body.tissue, settings());
      Wanderer hand(seed, {0, 0, body.top});
      std::mt19937_64 random(seed);
      std::uniform_real_distribution<double> uniform(-1, 1);
      const auto anywhere = [&](double size) {
        const double x = uniform(random), y = uniform(random), z = uniform(random);
        return size * dvec3(x, y, z);
      };
      std::uint64_t cuts = 0;
      for (int i = 0; i < std::min(left, kRound); ++i, ++all) {
        Pose X = hand.next(1e-3);
        double pedal = uniform(random);
        switch (random() % 400) {
          case 0:
            hand.leap_to(dvec3(0, 0, body.top) + anywhere(6.0_mm));
            break;
          case 1:
            X.p = {std::numeric_limits<double>::quiet_NaN(), 0, 0};
            break;
          case 2:
            X.p = dvec3(std::numeric_limits<double>::infinity());
            break;
          case 3:
            X.R = dquat(0, 0, 0, 0);
            break;
          case 4:
            X.p = anywhere(1e30);
            break;
          case 5:
            pedal = std::numeric_limits<double>::quiet_NaN();
            break;
          case 6:
            bench.t -= 5'000'000;  // the clock goes back
            break;
          case 7:
            bench.t += 3'000'000'000;
            break;
          case 8:
            bench.carver.undo();
            break;
          default:
            break;
        }
        const ServoTick& tick = bench.tick(X, pedal);
        ASSERT_NO_FATAL_FAILURE(expect_sense(tick)) << "tick " << i;
        ASSERT_GE(tick.cuts, cuts) << "tick " << i;
        cuts = tick.cuts;
        for (const double removed : tick.removed) ASSERT_GE(removed, -1e-15) << "tick " << i;
        if (tick.faults & bits(Fault::kBadInput)) {
          ++bad;
          ASSERT_EQ(tick.f_T_W, dvec3(0)) << "tick " << i;
        }
      }
    }
  }
  EXPECT_GT(bad, all / 500);
}

INSTANTIATE_TEST_SUITE_P(Heads, HostileHandAmongSpheres, testing::Values("round_012", "cylinder_010", "explorer"),
                         [](const auto& head) { return std::string(head.param); });

}  // namespace
}  // namespace typodont
