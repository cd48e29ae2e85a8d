// Hands no human has, with every kind of head on the worst shapes: whatever comes in, what goes out is finite, bounded
// and explained, and no hand gets energy from nothing. Short here; ./run stress makes ten million ticks of it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "engine/base/units.h"
#include "tests/support/campaign.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::ServoSettings;
using test::campaign;
using test::HapticBench;

constexpr double kForceLimit = 8, kTorqueLimit = 0.5;  // N, N·m

struct Body {
  const char* name;
  const char* tissue;  // JSON, or a volume of assets/
  dvec3 top;           // m: no tissue is higher
};

/// A tooth of enamel and dentin with a bore, and all there is where a field's gradient jumps or a body is thinner than
/// a voxel.
constexpr Body kBodies[] = {
    {"the molar", "assets/teeth/molar.vdb", {6.8_mm, 5.5_mm, 20.5_mm}},
    {"a bored ball of two tissues",
     R"({"voxel_mm": 0.2, "solids": [
      {"tissue": "enamel", "solid": {"difference": [{"sphere": {"radius_mm": 4}}, {"cylinder": {"radius_mm": 0.8, "height_mm": 20}}]}},
      {"tissue": "dentin", "solid": {"difference": [{"sphere": {"radius_mm": 3}}, {"cylinder": {"radius_mm": 0.8, "height_mm": 20}}]}}]})",
     {0, 0, 4.0_mm}},
    {"a sheet of a tenth of a millimetre",
     R"({"voxel_mm": 0.1, "band_mm": 0.8, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [5, 5, 0.1]}}}]})",
     {0, 0, 0.05_mm}},
    {"a V-groove of 40 degrees",
     R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"difference": [
      {"box": {"size_mm": [5, 5, 3]}}, {"intersection": [{"box": {"size_mm": [6, 6, 6]}},
      {"halfspace": {"normal": [0.94, 0, -0.342], "offset_mm": 0}}, {"halfspace": {"normal": [-0.94, 0, -0.342], "offset_mm": 0}}]}]}}]})",
     {0, 0, 1.5_mm}},
    {"spikes",
     R"({"voxel_mm": 0.1, "solids": [
      {"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, -1.5], "size_mm": [5, 5, 1]}}},
      {"tissue": "enamel", "solid": {"union": [
        {"cone": {"center_mm": [-0.8, -0.8, 0], "axis": [0, 0, 1], "radius_mm": 0.4, "height_mm": 2}},
        {"cone": {"center_mm": [0.8, -0.8, 0], "axis": [0, 0, 1], "radius_mm": 0.2, "height_mm": 2}},
        {"cone": {"center_mm": [-0.8, 0.8, 0], "axis": [0.3, 0, 1], "radius_mm": 0.3, "height_mm": 2}},
        {"cylinder": {"center_mm": [0.8, 0.8, 0], "axis": [0, 0, 1], "radius_mm": 0.13, "height_mm": 2}}]}}]})",
     {0, 0, 1.0_mm}},
    {"a slot, its medial plane amid the heads",
     R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"difference": [
      {"box": {"size_mm": [5, 5, 3]}}, {"box": {"center_mm": [0, 0, 0.5], "size_mm": [1.3, 9, 3]}}]}}]})",
     {0, 0, 1.5_mm}},
    {"a tunnel hardly wider than the smaller heads",
     R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"difference": [
      {"box": {"size_mm": [4, 4, 4]}}, {"cylinder": {"axis": [0, 0, 1], "radius_mm": 0.55, "height_mm": 9}}]}}]})",
     {0, 0, 2.0_mm}},
    {"a ring about its medial axis",
     R"({"voxel_mm": 0.1, "solids": [
      {"tissue": "enamel", "solid": {"torus": {"axis": [0, 0, 1], "major_mm": 1.4, "minor_mm": 0.6}}}]})",
     {0, 0, 0.6_mm}},
    {"two balls that touch",
     R"({"voxel_mm": 0.1, "solids": [
      {"tissue": "enamel", "solid": {"sphere": {"center_mm": [-1.5, 0, 0], "radius_mm": 1.5}}},
      {"tissue": "dentin", "solid": {"sphere": {"center_mm": [1.5, 0, 0], "radius_mm": 1.5}}}]})",
     {0, 0, 1.5_mm}}};

haptics::TissueVolume volume_of(const Body& body) {
  const std::string tissue = body.tissue;
  if (tissue.ends_with(".vdb")) return haptics::TissueVolume::load(tissue);
  return haptics::TissueVolume(haptics::read_solids(Json::parse(tissue, body.name)));
}

/// A hand that wanders around a place at up to 0.2 m/s, pushed about with up to 20 m/s², ten times what the controller
/// foresees and more than arms can; it turns the tool in every direction meanwhile. Every so often it changes its mind
/// about how fast.
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
    if (const double rate = glm::length(turn_); rate > 0)
      R_ = glm::normalize(glm::angleAxis(rate * dt, turn_ / rate) * R_);
    p_ += dt * v_;
    return {p_, R_};
  }
  void leap_to(const dvec3& p) { p_ = p; }

 private:
  dvec3 anywhere() { return {normal_(random_), normal_(random_), normal_(random_)}; }
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_{0, 1};
  double speed_ = 0.03;
  dvec3 home_, p_, v_{0}, turn_{0};
  dquat R_{1, 0, 0, 0};
};

class HostileHand : public testing::TestWithParam<const char*> {
 protected:
  static ServoSettings settings() {
    ServoSettings s;
    s.tool = haptics::read_tool(Json::load(fmt::format("assets/tools/{}.json", GetParam())));
    s.spindle.free_speed = 300.0_krpm;
    s.force_limit = kForceLimit;
    s.torque_limit = kTorqueLimit;
    return s;
  }

  /// What holds in every tick, whoever's hand it is.
  static void expect_sense(const ServoTick& tick) {
    ASSERT_TRUE(is_finite(tick.f_T_W) && is_finite(tick.tau_T_W) && is_finite(tick.X_WG.p));
    ASSERT_TRUE(std::isfinite(tick.energy) && std::isfinite(tick.depth) && std::isfinite(tick.contact_area));
    ASSERT_LE(glm::length(tick.f_T_W), kForceLimit * (1 + 1e-9));
    ASSERT_LE(glm::length(tick.tau_T_W), kTorqueLimit * (1 + 1e-9));
  }

  // The tissue is made anew before all of it is cut away.
  static constexpr int kRound = 4000;
};

TEST_P(HostileHand, GetsNoEnergyFromNothingHoweverItProbesAndDrillsTheWorstShapesAndFromTheSpindleNoMoreThanItsWork) {
  std::uint64_t seed = 1;
  double felt = 0;
  for (const Body& body : kBodies) {
    for (int left = campaign(600); left > 0; left -= kRound, ++seed) {
      SCOPED_TRACE(fmt::format("{}, seed {}", body.name, seed));
      const ServoSettings s = settings();
      HapticBench bench(volume_of(body), s);
      Wanderer hand(seed, body.top + dvec3(0, 0, haptics::near_reach(s.tool) + 0.2_mm));  // not born inside
      const bool drills = seed % 3 != 0;
      double work = 0;  // J, of the spindle
      for (int i = 0; i < std::min(left, kRound); ++i) {
        // Down into the body and up again, so that all of it is met.
        const Pose at = hand.next(1e-3);
        const dvec3 p = at.p - dvec3(0, 0, 1.5_mm * (1 - std::cos(2e-3 * kPi * i)));
        const ServoTick& tick = bench.tick({p, at.R}, drills ? 1 : 0);
        ASSERT_NO_FATAL_FAILURE(expect_sense(tick)) << "tick " << i;
        ASSERT_GE(tick.energy, -1e-9) << "tick " << i;
        work += tick.cutting_power * 1e-3;
        ASSERT_LE(tick.spindle_energy, work + 1e-7) << "tick " << i;
        felt = std::max(felt, glm::length(tick.f_T_W));
      }
    }
  }
  EXPECT_GT(felt, 0.1);
}

TEST_P(HostileHand, NeverGetsNonsenseForNonsense) {
  std::uint64_t seed = 1;
  int bad = 0, all = 0;
  for (const Body& body : kBodies) {
    for (int left = campaign(500); left > 0; left -= kRound, ++seed) {
      SCOPED_TRACE(fmt::format("{}, seed {}", body.name, seed));
      HapticBench bench(volume_of(body), settings());
      Wanderer hand(seed, body.top);
      std::mt19937_64 random(seed);
      std::uniform_real_distribution<double> uniform(-1, 1);
      const auto anywhere = [&](double size) {
        return size * dvec3(uniform(random), uniform(random), uniform(random));
      };
      PerTissue removed{};
      std::uint64_t cuts = 0;
      for (int i = 0; i < std::min(left, kRound); ++i, ++all) {
        Pose X = hand.next(1e-3);
        double pedal = uniform(random);
        switch (random() % 500) {
          case 0:
            hand.leap_to(body.top + anywhere(6.0_mm));
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
            bench.t -= 5'000'000;
            break;  // the clock goes back
          case 7:
            bench.t += 3'000'000'000;
            break;
          default:
            break;
        }
        const ServoTick& tick = bench.tick(X, pedal);
        ASSERT_NO_FATAL_FAILURE(expect_sense(tick)) << "tick " << i;
        ASSERT_GE(tick.cuts, cuts) << "tick " << i;
        cuts = tick.cuts;
        for (std::size_t t = 0; t < removed.size(); ++t) {
          ASSERT_GE(tick.removed[t], removed[t] - 1e-18) << "tick " << i;
          removed[t] = tick.removed[t];
        }
        if (tick.faults & bits(Fault::kBadInput)) {
          ++bad;
          ASSERT_EQ(tick.f_T_W, dvec3(0)) << "tick " << i;
        }
      }
    }
  }
  EXPECT_GT(bad, all / 500);
}

INSTANTIATE_TEST_SUITE_P(Heads, HostileHand,
                         testing::Values("round_012", "round_040", "flame_012", "cylinder_010",
                                         "round_end_cylinder_012", "end_guarded_cylinder_010", "cone_016", "pear_010",
                                         "inverted_cone_010", "excavator_spoon", "explorer"),
                         [](const auto& head) { return std::string(head.param); });

}  // namespace
}  // namespace typodont
