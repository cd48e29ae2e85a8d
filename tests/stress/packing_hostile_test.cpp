// Tests hands that move as no human hand can, in contact with spheres. The output is finite and bounded, nothing passes
// through a wall, and no hand gets energy that it did not put in. The normal run is short; ./run stress tests ten
// million ticks.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "engine/base/units.h"
#include "haptics/contact_method.h"
#include "tests/support/campaign.h"
#include "tests/support/hostile_hand.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::ServoSettings;
using namespace test;

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

constexpr const Body& kSheet = kBodies[1];
constexpr double kSheetHalf = 2.5_mm;  // half the sheet's width

ServoSettings settings_of(const std::string& head) {
  ServoSettings s = hostile_settings(haptics::read_tool(Json::load(fmt::format("assets/tools/{}.json", head))));
  s.method = haptics::read_contact_method(Json::parse(R"({"packing": {"spheres": 2000, "tool_spheres": 30}})", "t"));
  return s;
}

class HostileHandAmongSpheres : public testing::TestWithParam<const char*> {};

/// Returns true if the head's centre moved through the sheet. Around the sheet's edge it may get to the other side: the
/// shank is longer than the sheet is wide, so a tool that is held upside down can slip off the edge and turn below the
/// sheet.
bool passes_sheet(const dvec3& from, const dvec3& to) {
  if ((from.z > 0) == (to.z > 0)) return false;
  const dvec3 at = glm::mix(from, to, from.z / (from.z - to.z));
  return std::max(std::abs(at.x), std::abs(at.y)) < kSheetHalf;
}

/// The passivity controller cannot foresee a hand that changes its velocity more than in any tick before
/// (docs/passivity.md, "Limits"). This factor is the smallest ratio of the velocity change in the tick in which the
/// hand receives energy to the largest velocity change before.
constexpr double kMoreAbruptly = 1.2;
// J. A hand gets at most this energy, and at most its force times the displacement that was not foreseen.
constexpr double kUnforeseen = -5e-6;
constexpr int kOneOf = 200;  // hands

struct Outcome {
  double felt = 0;     // N, the largest force
  int unforeseen = 0;  // hands that got energy
  double lowest = 0;   // m, the lowest head's centre
  double ledger = 0;   // J, the lowest value of the energy ledger
  int ticks = 0;
};

/// One hand for this many ticks. Every third hand does not drill.
void follow_hand(const Body& body, const ServoSettings& s, std::uint64_t seed, int ticks, Outcome& outcome) {
  SCOPED_TRACE(fmt::format("{}, seed {}", body.name, seed));
  HapticBench bench(body.tissue, s);
  const dvec3 home(0, 0, body.top + haptics::near_reach(s.tool) + 0.2_mm);  // not born inside
  ErraticHand hand(seed, home);
  const bool drills = seed % 3 != 0, sheet = &body == &kSheet;
  dvec3 head = home;
  double work = 0;  // J, of the spindle
  // m per tick, velocity of the hand and its largest change before this tick
  dvec3 last = home, moved(0);
  double abruptly = 0, force = 0;  // force: N, force in the last tick
  for (int i = 0; i < ticks; ++i) {
    const Pose at = hand.next(1e-3);
    dvec3 p = at.p - dvec3(0, 0, 1.5_mm * (1 - std::cos(2e-3 * kPi * i)));
    if (sheet) p = glm::clamp(p, dvec3(-1.0_mm, -1.0_mm, -1), dvec3(1.0_mm, 1.0_mm, 1));
    const ServoTick& tick = bench.tick({p, at.R}, drills ? 1 : 0);
    ASSERT_NO_FATAL_FAILURE(expect_sense(tick)) << "tick " << i;
    ++outcome.ticks;
    outcome.ledger = std::min(outcome.ledger, tick.energy);
    const double change = glm::distance(p - last, moved);
    if (tick.energy < -1e-9) {
      EXPECT_GT(change, kMoreAbruptly * abruptly) << "tick " << i << ": " << tick.energy << " J";
      EXPECT_GE(tick.energy, std::max(kUnforeseen, -force * (change - abruptly))) << "tick " << i;
      ++outcome.unforeseen;
      break;
    }
    moved = p - last, last = p;
    if (i > 0) abruptly = std::max(abruptly, change);
    work += tick.cutting_power * 1e-3;
    ASSERT_LE(tick.spindle_energy, work + 1e-7) << "tick " << i;
    if (sheet && !drills) {
      ASSERT_FALSE(passes_sheet(head, tick.X_WG.p)) << "tick " << i;
    }
    head = tick.X_WG.p;
    outcome.lowest = std::min(outcome.lowest, head.z);
    force = glm::length(tick.f_T_W);
    outcome.felt = std::max(outcome.felt, force);
  }
}

TEST_P(HostileHandAmongSpheres, GainsNoEnergyAndPassesNoWall) {
  std::uint64_t seed = campaign_seed(1);
  Outcome outcome;
  int hands = 0;
  for (const Body& body : kBodies) {
    for (int left = campaign(4200); left > 0; left -= kHostileRound, ++seed, ++hands) {
      ASSERT_NO_FATAL_FAILURE(follow_hand(body, settings_of(GetParam()), seed, std::min(left, kHostileRound), outcome));
    }
  }
  EXPECT_GT(outcome.felt, 0.1);
  EXPECT_LE(outcome.unforeseen, hands / kOneOf) << "of " << hands << " hands";
  RecordProperty("unforeseen", outcome.unforeseen);
  RecordProperty("hands", hands);
  RecordProperty("ticks", outcome.ticks);
  RecordProperty("lowest_ledger_J", fmt::format("{:.3g}", outcome.ledger));
}

// Two hands of the long campaign. The shank slips off the sheet's edge, and the head gets below the sheet beside it.
// follow_hand() checks in every tick that the head does not pass through the sheet.
TEST(HostileHandAtASheet, AToolThatSlipsOffTheEdgeDoesNotPassThroughTheSheet) {
  const struct {
    const char* head;
    std::uint64_t seed;
  } hands[] = {{"round_012", 54}, {"cylinder_010", 36}};
  for (const auto& hand : hands) {
    SCOPED_TRACE(hand.head);
    Outcome outcome;
    ASSERT_NO_FATAL_FAILURE(follow_hand(kSheet, settings_of(hand.head), hand.seed, 3500, outcome));
    EXPECT_LT(outcome.lowest, -kSheet.top) << "the head gets below the sheet";
  }
}

// Two hands of long campaigns. The first hand touches two balls. In the 20th tick of the contact, its velocity changes
// by 42 mm/s, 3.3 times as much as in any tick before. The force is 1 mN, and the ledger contains 14 nJ. The second
// hand presses a cylinder through a sheet, and then moves by 0.17 mm in one tick.
TEST(HostileHandThatReverses, AHandThatSuddenlyTurnsRoundGetsAtMostTheForceTimesTheUnforeseenMotion) {
  const struct {
    const Body& body;
    std::uint64_t seed;
    double most;  // J, upper limit of the energy that the hand gets
  } hands[] = {{kBodies[3], 100386, 10e-9}, {kSheet, 200133, -kUnforeseen}};
  for (const auto& hand : hands) {
    Outcome outcome;
    ASSERT_NO_FATAL_FAILURE(follow_hand(hand.body, settings_of("cylinder_010"), hand.seed, kHostileRound, outcome));
    EXPECT_EQ(outcome.unforeseen, 1);
    EXPECT_GT(outcome.ledger, -hand.most);
  }
}

INSTANTIATE_TEST_SUITE_P(Heads, HostileHandAmongSpheres, testing::Values("round_012", "cylinder_010", "explorer"),
                         [](const auto& head) { return std::string(head.param); });

}  // namespace
}  // namespace typodont
