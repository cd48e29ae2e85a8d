// Tests a tool that its contacts hold after the hand has left: it comes out on the path on which it went in, or the
// user gets a message.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "engine/base/units.h"
#include "haptics/contact/retreat_path.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::RetreatPath;
using test::HapticBench;

constexpr const char* kBlock =
    R"({"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [14, 10, 8]}}}]})";
constexpr double kTop = 4.0_mm, kDeep = 2.5_mm;

haptics::ServoSettings drill() {
  haptics::ServoSettings settings;
  settings.tool.diameter = settings.tool.length = 1.2_mm;
  settings.spindle.free_speed = 300e3 / 60 * 2 * kPi;
  return settings;
}

struct Hand {
  HapticBench bench;
  dvec3 at{0, 0, kTop + 2.0_mm};
  double worst_step = 0;  // N from tick to tick
  std::uint32_t faults = 0;

  explicit Hand(const haptics::ServoSettings& settings) : bench(kBlock, settings) {}
  /// Moves to `to` in a straight line. `speed` is in m/s.
  void go(const dvec3& to, double pedal, double speed = 10e-3) {
    const int ticks = std::max(1, static_cast<int>(glm::length(to - at) / (speed * 1e-3)));
    const dvec3 from = at;
    for (int i = 1; i <= ticks; ++i) tick(from + (to - from) * (static_cast<double>(i) / ticks), pedal);
  }
  void rest(double seconds, double pedal = 0) {
    for (int i = 0; i < 1e3 * seconds; ++i) tick(at, pedal);
  }
  dvec3 tool() const { return bench.last.X_WG.p; }

 private:
  void tick(const dvec3& p, double pedal) {
    at = p;
    const dvec3 before = bench.last.f_T_W;
    bench.tick({p}, pedal);
    worst_step = std::max(worst_step, glm::length(bench.last.f_T_W - before));
    faults |= bench.last.faults;
  }
};

/// Drills down into the block and sideways below remaining tissue. Then the drill is off, and the hand moves straight
/// up.
void drill_under_a_roof(Hand& hand) {
  hand.go({0, 0, kTop - kDeep - 0.5_mm}, 1, 4e-3);
  hand.rest(1.5, 1);
  hand.go({3.0_mm, 0, kTop - kDeep - 0.5_mm}, 1, 0.6e-3);
  hand.rest(3, 1);
  ASSERT_GT(hand.tool().x, 2.0_mm);
  ASSERT_LT(hand.tool().z, kTop - 2.0_mm);
  hand.rest(0.5, 0);
  hand.go({3.0_mm, 0, kTop + 4.0_mm}, 0);
}

TEST(Retreat, ABurUnderAnOverhangRetreatsAlongItsPathWithoutCuttingWhenTheHandHasLeft) {
  Hand hand(drill());
  drill_under_a_roof(hand);
  hand.faults = 0;
  hand.worst_step = 0;
  const std::uint64_t cuts = hand.bench.last.cuts;
  hand.rest(3);
  EXPECT_EQ(hand.bench.last.cuts, cuts);
  EXPECT_LT(glm::length(hand.tool() - hand.at), 1e-6);
  EXPECT_TRUE(hand.faults & bits(Fault::kWedged)) << "the user was told";
  EXPECT_FALSE(hand.bench.last.faults & bits(Fault::kWedged)) << "no longer";
  EXPECT_LT(hand.worst_step, 0.08);  // force of the damper at the speed of the hand
}

TEST(Retreat, AHandThatPushesIntoAWallIsHeldHoweverLong) {
  Hand hand(drill());
  hand.go({0, 0, kTop - kDeep - 0.5_mm}, 1, 4e-3);
  hand.rest(1.5, 1);
  hand.rest(0.5, 0);
  hand.go({3.0_mm, 0, kTop - kDeep}, 0);
  const dvec3 held = hand.tool();
  hand.rest(3);
  EXPECT_LT(glm::length(hand.tool() - held), 0.1_mm);
  EXPECT_FALSE(hand.faults & bits(Fault::kWedged));
}

TEST(Retreat, AMissingPathBackIsReportedToTheUser) {
  // The session begins inside a closed hollow, so the tool did not come in on any path.
  HapticBench bench(
      R"({"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"difference": [
           {"box": {"size_mm": [6, 6, 6]}}, {"sphere": {"radius_mm": 1.2}}]}}]})",
      drill());
  bench.tick({dvec3(0)});
  for (int i = 0; i <= 600; ++i) bench.tick({dvec3(0, 0, 1e-5 * i)});
  int told_after = -1;
  for (int i = 0; i < 2000; ++i) {
    bench.tick({dvec3(0, 0, 6.0_mm)});
    if (told_after < 0 && bench.last.faults & bits(Fault::kWedged)) told_after = i;
  }
  EXPECT_LT(bench.last.X_WG.p.z, 1.0_mm);
  EXPECT_GE(told_after, 0);
  EXPECT_TRUE(bench.last.faults & bits(Fault::kWedged));
}

TEST(Retreat, OfAPathToAndFroOnlyOneWayRemainsAndItsNearestPointIsFound) {
  RetreatPath path;
  path.begin(dvec3(0));
  for (int k = 0; k < 21; ++k) {
    for (int i = 0; i <= 100; ++i) path.add({k % 2 ? 100.0 - i : i, 0, 0});
  }
  EXPECT_LE(path.size(), 101u);
  EXPECT_NEAR(path.last().x, 100, 0.8);
  EXPECT_NEAR(static_cast<double>(path.nearest({50, 3, 0}, 4)), 50, 1);
  EXPECT_EQ(path.nearest({50, 3, 0}, 2), path.size());
}

TEST(Retreat, APathEqualsOneThatComparesEachNewPointWithAllItsPoints) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  RetreatPath path;
  std::vector<dvec3> simple;
  const auto begin = [&](const dvec3& c) {
    path.begin(c);
    simple = {c};
  };
  const auto add = [&](const dvec3& c) {
    path.add(c);
    const double moved = glm::length(c - simple.back());
    if (moved > 8) simple = {c};
    if (moved > 8 || moved < 0.5) return;
    const auto visited =
        std::find_if(simple.begin(), simple.end(), [&](const dvec3& p) { return glm::length(c - p) <= 0.7; });
    if (visited != simple.end()) return simple.resize(static_cast<std::size_t>(visited - simple.begin()) + 1);
    if (simple.size() == 512) {
      for (std::size_t i = 0; i < 256; ++i) simple[i] = simple[2 * i];
      simple.resize(256);
    }
    simple.push_back(c);
  };
  dvec3 c(0), way(1, 0, 0);
  begin(c);
  std::size_t longest = 0, turned_back = 0;
  for (int i = 0; i < 50'000; ++i) {
    // The hand moves on, sometimes turns, sometimes leaps, and sometimes follows its path back.
    if (i % 50 == 0) way = dvec3(uniform(random), uniform(random), uniform(random));
    c += way * (i % 5000 == 4999 ? 10.0 : 0.3 + uniform(random));
    if (i % 400 == 399) {
      for (int k = 0; k < 30 && path.size() > 1; ++k) path.drop_last(), simple.pop_back();
      c = path.last();
    }
    if (i % 9000 == 8999) begin(c);
    const std::size_t size = simple.size();
    add(c);
    turned_back += simple.size() < size;
    longest = std::max(longest, size);
    ASSERT_EQ(path.size(), simple.size()) << i;
    ASSERT_EQ(path.last(), simple.back()) << i;
  }
  EXPECT_GT(turned_back, 100u);
  EXPECT_GT(longest, 500u);
}

}  // namespace
}  // namespace typodont
