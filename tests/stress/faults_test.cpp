// Tests each row of the table in docs/safety.md: the effect of each fault on the force, and its delay.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <thread>

#include "engine/app/live/session.h"
#include "engine/app/recording/resume.h"
#include "engine/app/stepped.h"
#include "engine/base/units.h"
#include "engine/session/session_data.h"
#include "engine/session/strings.h"
#include "haptics/devices/safe_device.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::HandSample;

constexpr int kFaults = 12;
constexpr double kPush = 0.5;  // N, of a ball 0.5 mm deep in enamel

/// Returns a scene with a block of enamel below z = 0 and a tool above it.
Scene block(const std::string& more = R"("tool": {"shape": "sphere", "diameter_mm": 1, "cuts": false})") {
  return parse_scene(
      Json::parse(fmt::format(R"({{"tissue": {{"voxel_mm": 0.1, "solids": [{{"tissue": "enamel", "solid": {{"box":
        {{"center_mm": [0, 0, -3], "size_mm": [24, 12, 6]}}}}}}]}}, "friction": false, "coupling": {{"stiffness_N_per_mm": 1,
        "damping_Ns_per_mm": 0}}, "materials": {{"enamel": {{"stiffness_N_per_mm": 1}}}}, "parts": ["haptics"], {}}})",
                              more),
                  "block"),
      {});
}

/// Servo and carver on the block, with a hand that the test moves.
class Hand {
 public:
  explicit Hand(const Scene& scene) : loop(scene, load_tissue(scene), 1000) {}
  const ServoTick& tick(const dvec3& p, double pedal = 0, std::uint32_t faults = 0) {
    HandSample sample;
    sample.t = t += 1'000'000;
    sample.X_WT.p = p;
    sample.pedal = pedal;
    sample.faults = faults;
    before = tick_.f_T_W;
    return tick_ = loop.tick(sample);
  }
  /// In a straight line, at so many m/s.
  void go(const dvec3& from, const dvec3& to, double speed, double pedal = 0) {
    const int ticks = static_cast<int>(glm::length(to - from) / speed * 1000) + 1;
    for (int i = 1; i <= ticks; ++i) {
      tick(glm::mix(from, to, static_cast<double>(i) / ticks), pedal);
      seen |= tick_.faults;
      worst_step = std::max(worst_step, glm::length(tick_.f_T_W - before));
    }
  }
  /// Presses the tool into the top of the block by kPush and holds it at rest.
  void press(double pedal = 0) {
    go(over(), in(), 20e-3, pedal);
    for (int i = 0; i < 50; ++i) tick(in(), pedal);
  }
  bool has(Fault fault) const { return (tick_.faults & bits(fault)) != 0; }
  double force() const { return glm::length(tick_.f_T_W); }
  static dvec3 over() { return {0, 0, 1.5_mm}; }
  static dvec3 in() { return {0, 0, 0}; }  // the ball's centre on the surface: half a millimetre deep

  SteppedSession loop;
  ServoTick tick_;
  Nanos t = 0;
  dvec3 before{0};
  std::uint32_t seen = 0;
  double worst_step = 0;
};

/// Emulates a device with motors behind the safety layer, in simulated time. The device carries out every command.
struct Motors {
  class Device : public haptics::HapticDevice {
   public:
    explicit Device(Motors& all) : all_(all) {
      info_.force_limit = 5;
      info_.continuous_force = 5;
    }
    const haptics::DeviceInfo& info() const noexcept override { return info_; }
    bool read(HandSample& sample) noexcept override {
      all_.t += 1'000'000;
      sample = all_.next;
      sample.t = all_.t;
      return all_.alive;
    }
    void write(const dvec3& f, const dvec3&) noexcept override { all_.force = f; }
    void release() noexcept override { all_.force = dvec3(0); }
    std::uint32_t faults() const noexcept override { return all_.faults; }

   private:
    Motors& all_;
    haptics::DeviceInfo info_;
  };

  Motors() {
    auto device = std::make_unique<Device>(*this);
    auto options = haptics::SafeDevice::options_for(device->info());
    options.watchdog_thread = false;
    options.clock = [this] { return t; };
    safe = std::make_unique<haptics::SafeDevice>(std::move(device), options);
  }
  void ticks(int n, const dvec3& f) {
    for (int i = 0; i < n; ++i) {
      safe->read(sample);
      seen |= safe->faults();
      safe->write(f, dvec3(0));
      seen |= safe->faults();
    }
  }
  /// Leaves the hand free for long enough, and then requests a force.
  void give(const dvec3& f) {
    ticks(100, dvec3(0));
    ticks(400, f);
    seen = 0;
  }
  /// After a fault the force must stay zero until the hand was free for 50 ms. Then it must come back within 0.25 s.
  void expect_back_only_when_free(const dvec3& f) {
    ticks(500, f);
    EXPECT_EQ(force, dvec3(0)) << "the hand was never free";
    ticks(60, dvec3(0));
    ticks(20, f);
    EXPECT_LT(glm::length(force), 0.2 * glm::length(f)) << "it rises slowly";
    ticks(280, f);
    EXPECT_NEAR(glm::length(force), glm::length(f), 1e-9);
  }

  Nanos t = 0;
  HandSample next, sample;
  bool alive = true;
  std::uint32_t faults = 0, seen = 0;
  dvec3 force{0};
  std::unique_ptr<haptics::SafeDevice> safe;
};

TEST(Faults, EveryFaultBitIsDocumentedWithItsDisplayedText) {
  std::map<std::uint32_t, std::pair<std::string, std::string>> rows;  // fault, what is said
  std::ifstream table("docs/safety.md");
  for (std::string line; std::getline(table, line);) {
    std::istringstream cells(line);
    std::string empty, bit, fault, cell, last;
    std::getline(cells, empty, '|'), std::getline(cells, bit, '|'), std::getline(cells, fault, '|');
    while (std::getline(cells, cell, '|')) last = cell;
    if (bit.empty() || bit.find_first_not_of(" 0123456789") != std::string::npos) continue;
    rows[static_cast<std::uint32_t>(std::stoul(bit))] = {fault, last};
  }
  EXPECT_EQ(rows.size(), static_cast<std::size_t>(kFaults));
  for (std::uint32_t bit = 1; bit < 1u << kFaults; bit <<= 1) {
    const std::string key(session::fault_name(bit));
    ASSERT_TRUE(rows.contains(bit)) << bit;
    EXPECT_EQ(rows[bit].first, fmt::format(" `{}` ", key));
    EXPECT_EQ(rows[bit].second,
              fmt::format(" {} ", session::text(fmt::format("fault.{}", key), session::Language::kEnglish)));
  }
  EXPECT_EQ(session::fault_name(1u << kFaults), "unknown") << "a new fault wants a row";
}

TEST(Faults, BadInputGivesZeroForceInTheSameTickAndTheForceReturnsWithoutAStep) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const dvec3& bad : {dvec3(nan, 0, 0), dvec3(0, 0, 200)}) {
    Hand hand(block());
    hand.press();
    ASSERT_NEAR(hand.force(), kPush, 0.01);
    hand.tick(bad);
    EXPECT_TRUE(hand.has(Fault::kBadInput));
    EXPECT_EQ(hand.force(), 0);
    for (int i = 0; i < 16; ++i) {
      hand.tick(Hand::in());
      EXPECT_LE(std::abs(hand.force() - glm::length(hand.before)), kPush / 15 + 0.01) << i;
    }
    EXPECT_NEAR(hand.force(), kPush, 0.02);
    EXPECT_EQ(hand.tick_.faults, 0u);
  }
  Motors motors;
  motors.give({0, 0, 1});
  ASSERT_EQ(motors.force, dvec3(0, 0, 1));
  motors.next.X_WT.p.x += 0.02;  // 20 m/s
  motors.ticks(1, {0, 0, 1});
  EXPECT_TRUE(motors.seen & bits(Fault::kBadInput));
  EXPECT_EQ(motors.force, dvec3(0));
  motors.expect_back_only_when_free({0, 0, 1});
}

TEST(Faults, AStalePatchIsReportedAfter20MillisecondsAndDoesNotChangeTheForce) {
  Hand late(block()), in_time(block());
  late.press(), in_time.press();
  late.loop.hold_carver(true);
  // The servo counts a patch as due when the tool is farther than the body's travel from its centre, which is half of
  // this length (haptics/contact/patch_model.cpp).
  const double travel = 2 * late.loop.carver().body().travel();
  int said_after = -1, due_for = 0;
  for (int i = 0; i < 200; ++i) {
    const dvec3 p = Hand::in() + dvec3(std::min(i * 20e-6, 1.0_mm), 0, 0);  // nearly to the end of the patch
    late.tick(p), in_time.tick(p);
    ASSERT_FALSE(late.has(Fault::kPatchEdge)) << i;
    EXPECT_NEAR(glm::length(late.tick_.f_T_W - in_time.tick_.f_T_W), 0, 1e-6) << i;
    const ServoTick& tick = late.tick_;
    const dvec3 wanted = haptics::snapshot_center_for(tick.X_WG.p, tick.X_WT.p, travel);
    if (haptics::snapshot_due_for(wanted, late.loop.servo().snapshot().center_W, travel)) ++due_for;
    if (late.has(Fault::kStalePatch) && said_after < 0) said_after = due_for;
  }
  EXPECT_NEAR(said_after, 20, 2) << "ms";
  EXPECT_TRUE(late.has(Fault::kStalePatch));
  EXPECT_NE(in_time.tick_.patch, late.tick_.patch) << "the carver that is not held delivers a new patch";
  EXPECT_EQ(in_time.tick_.faults, 0u);
}

TEST(Faults, OutsideThePatchThePlaneOfTheLastContactHoldsTheToolWithoutCutting) {
  for (const double pedal : {0.0, 1.0}) {
    Hand hand(pedal > 0 ? block(R"("tool": "round_010", "spindle": "air_turbine")") : block());
    hand.go(Hand::over(), {0, 0, 0.2_mm}, 20e-3, pedal);
    hand.loop.hold_carver(true);
    const double push = hand.force();
    hand.worst_step = 0;
    hand.go({0, 0, 0.2_mm}, {4.0_mm, 0, 0.2_mm}, 20e-3, pedal);
    ASSERT_TRUE(hand.has(Fault::kPatchEdge));
    EXPECT_NEAR(hand.force(), push, pedal > 0 ? 0.5 : 1e-3);
    const std::uint64_t cuts = hand.tick_.cuts;
    const double held = hand.force();
    EXPECT_GT(held, 0.02);
    for (int i = 0; i < 3000; ++i) hand.tick({4.0_mm, 0, 0.2_mm}, pedal);
    EXPECT_NEAR(hand.force(), held, 0.01) << "it does not fade";
    EXPECT_EQ(hand.tick_.cuts, cuts);
    EXPECT_LT(hand.worst_step, 0.02);
  }
}

TEST(Faults, ThePlaneOfTheLastContactYieldsHalfANewtonAboveTheForceAndEndsAfterTenMillimetres) {
  Hand hand(block());
  hand.press();
  hand.loop.hold_carver(true);
  hand.go(Hand::in(), {3.0_mm, 0, 0}, 20e-3);
  ASSERT_TRUE(hand.has(Fault::kPatchEdge));
  hand.worst_step = 0;
  hand.go({3.0_mm, 0, 0}, {3.0_mm, 0, -3.0_mm}, 20e-3);
  EXPECT_NEAR(hand.force(), kPush + 0.5, 0.01);
  hand.go({3.0_mm, 0, -3.0_mm}, {3.0_mm, 0, -10.0_mm}, 20e-3);
  EXPECT_EQ(hand.force(), 0);
  EXPECT_LT(hand.worst_step, 0.03);

  Hand leaves(block());
  leaves.press();
  leaves.loop.hold_carver(true);
  leaves.go(Hand::in(), {3.0_mm, 0, 0}, 20e-3);
  leaves.go({3.0_mm, 0, 0}, {3.0_mm, 0, 0.6_mm}, 20e-3);
  EXPECT_EQ(leaves.force(), 0) << "a hand that withdraws is free";
}

TEST(Faults, OutsideThePatchAPenaltyMethodHasThePlaneOfTheLastContactAndItsForceReturnsGradually) {
  const Scene scene =
      block(R"("model": "voxel_penalty", "tool": {"shape": "sphere", "diameter_mm": 1, "cuts": false})");
  Hand hand(scene);
  dvec3 p(0, 0, 0.2_mm);
  hand.go(Hand::over(), p, 20e-3);
  hand.loop.hold_carver(true);
  while (!hand.has(Fault::kPatchEdge) && p.x < 6.0_mm) hand.tick(p += dvec3(20e-6, 0, 0));
  ASSERT_TRUE(hand.has(Fault::kPatchEdge));
  EXPECT_NEAR(glm::length(hand.tick_.f_T_W - hand.before), 0, 0.01);
  EXPECT_GT(hand.force(), 0.1);
  hand.worst_step = 0;
  for (const double z : {0.2_mm, 0.0_mm}) {
    const dvec3 to(p.x, p.y, z);
    hand.go(p, to, 5e-3);
    p = to;
  }
  EXPECT_GT(hand.force(), 0.1);
  hand.loop.hold_carver(false);
  for (int i = 0; i < 200; ++i) hand.go(p, p, 1);
  EXPECT_FALSE(hand.has(Fault::kPatchEdge));
  EXPECT_LE(hand.worst_step, 0.025);

  Hand sinks(scene);
  p = dvec3(0, 0, 0.2_mm);
  sinks.go(Hand::over(), p, 20e-3);
  sinks.loop.hold_carver(true);
  while (!sinks.has(Fault::kPatchEdge) && p.x < 6.0_mm) sinks.tick(p += dvec3(20e-6, 0, 0));
  for (int i = 0; i < 20; ++i) sinks.tick(p);
  const double rested = sinks.force();
  sinks.go(p, p - dvec3(0, 0, 3.0_mm), 20e-3);
  EXPECT_LE(sinks.force(), rested + 0.55);
  sinks.go(p - dvec3(0, 0, 3.0_mm), p - dvec3(0, 0, 11.0_mm), 20e-3);
  EXPECT_EQ(sinks.force(), 0);

  Hand free(scene);
  free.go(Hand::over(), {0, 0, 4.0_mm}, 20e-3);
  free.loop.hold_carver(true);
  free.go({0, 0, 4.0_mm}, {0, 0, 0.1_mm}, 20e-3);
  EXPECT_TRUE(free.has(Fault::kPatchEdge));
  EXPECT_EQ(free.force(), 0);
  free.loop.hold_carver(false);
  double springs = 0;  // N, before the energy ledger limits the force
  for (int i = 0; i < 200; ++i) {
    const double before = springs;
    springs = glm::length(free.tick({0, 0, 0.1_mm}).f_model_W);
    EXPECT_LE(springs - before, 14e-3 + 1e-6) << i;
  }
  EXPECT_GT(springs, 0.2);
}

TEST(Faults, AFreeToolOutsideThePatchHasNoForceAndIsLedOutOfTissueGradually) {
  Hand hand(block());
  hand.press();  // paid for, so that the ledger is no limit
  hand.go(Hand::in(), {0, 0, 4.0_mm}, 20e-3);
  hand.loop.hold_carver(true);
  hand.go({0, 0, 4.0_mm}, {0, 0, -0.3_mm}, 20e-3);
  EXPECT_TRUE(hand.has(Fault::kPatchEdge));
  EXPECT_EQ(hand.force(), 0);
  hand.loop.hold_carver(false);
  bool led_out = false;
  for (int i = 0; i < 200; ++i) {
    hand.tick({0, 0, -0.3_mm});
    EXPECT_LE(hand.force() - glm::length(hand.before), 14e-3 + 1e-6) << i;
    led_out |= hand.has(Fault::kDeepPenetration);
  }
  EXPECT_TRUE(led_out);
  // When the hand pushes on, the force may grow only as far as the energy ledger allows.
  hand.worst_step = 0;
  hand.go({0, 0, -0.3_mm}, {0, 0, -0.6_mm}, 5e-3);
  EXPECT_GT(hand.force(), 0.1);
  EXPECT_LT(hand.worst_step, 0.05);
}

TEST(Faults, TheForceLimitAppliesInTheSameTickAndKeepsTheDirection) {
  Scene scene = block();
  scene.servo.force_limit = 0.3;
  Hand hand(scene);
  hand.go(Hand::over(), Hand::in(), 20e-3);
  EXPECT_TRUE(hand.seen & bits(Fault::kForceLimit));
  hand.tick({0, 0, -0.5_mm});
  EXPECT_TRUE(hand.has(Fault::kForceLimit));
  EXPECT_NEAR(hand.force(), 0.3, 1e-12);
  EXPECT_NEAR(hand.tick_.f_T_W.z, 0.3, 1e-9);
  Motors motors;
  motors.give({0, 0, 1});
  motors.ticks(10, {0, 0, 50});
  EXPECT_TRUE(motors.seen & bits(Fault::kForceLimit));
  EXPECT_LE(glm::length(motors.force), 5);
}

TEST(Faults, ALostDeviceHasNoForceInTheSameTickStopsTheDrillAndReturnsOnlyWithAFreeHand) {
  Hand hand(block(R"("tool": "round_010", "spindle": "air_turbine")"));
  hand.press(1);
  ASSERT_GT(hand.force(), 0.02);
  const double spindle = hand.tick_.spindle;
  hand.tick(Hand::in(), 1, bits(Fault::kDeviceLost));
  EXPECT_TRUE(hand.has(Fault::kDeviceLost));
  EXPECT_EQ(hand.force(), 0);
  const std::uint64_t cuts = hand.tick_.cuts;
  for (int i = 0; i < 2000; ++i) hand.tick(Hand::in(), 1, bits(Fault::kDeviceLost));
  EXPECT_LT(hand.tick_.spindle, 0.05 * spindle);
  EXPECT_EQ(hand.tick_.cuts, cuts);

  Motors motors;
  motors.give({0, 0, 1});
  motors.faults = bits(Fault::kDeviceLost);
  motors.ticks(1, {0, 0, 1});
  EXPECT_EQ(motors.force, dvec3(0));
  EXPECT_TRUE(motors.seen & bits(Fault::kDeviceLost));
  motors.faults = 0;
  motors.expect_back_only_when_free({0, 0, 1});
}

/// A hand in simulated time, for the thread of a live session's servo.
class Paced : public haptics::HapticDevice {
 public:
  Paced(int ticks, double rate) : left_(ticks) { info_.rate = rate; }
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(HandSample& sample) noexcept override {
    sample = {};
    sample.t = t_ += 1'000'000;
    sample.X_WT.p = {0, 0, std::max(1.2_mm - 20e-6 * to_seconds(t_) * 1000, 0.2_mm)};
    sample.pedal = 1;
    return left_-- > 0;
  }
  void write(const dvec3& f, const dvec3&) noexcept override { most = std::max(most, f.z); }
  double most = 0;  // N

 private:
  haptics::DeviceInfo info_;
  Nanos t_ = 0;
  int left_;
};

TEST(Faults, ACutLostOnItsWayToTheCarverDoesNotChangeTheForceAndEndsTheSessionProperly) {
  const Scene scene = block(R"("tool": "round_010", "spindle": "air_turbine")");
  double most[2];
  for (const bool late : {false, true}) {
    LiveSession s(scene, load_tissue(scene));
    Paced hand(400, 1000);
    s.serve(hand.info());
    s.wiring.patch.offer(s.carver, {0, 0, 0.7_mm});
    for (int i = 0; late && i < 1 << 17; ++i) s.wiring.event_logs.servo.write(ServoTick());
    servo_thread(s, hand);
    most[late] = hand.most;
    EXPECT_GT(s.last.cuts, 10u);
    if (!late) continue;
    carver_thread(s);
    EXPECT_NE(s.carver_failure, "");
    EXPECT_TRUE(s.wiring.stop);
  }
  EXPECT_GT(most[0], 0.05);
  EXPECT_EQ(most[0], most[1]);
}

TEST(Faults, TheSlewLimitSlowsARiseButNoFall) {
  Scene scene = block();
  scene.servo.slew_limit = 10;
  Hand hand(scene);
  hand.go(Hand::over(), Hand::in(), 20e-3);
  EXPECT_TRUE(hand.seen & bits(Fault::kSlewLimit));
  for (int i = 0; i < 100; ++i) hand.tick(Hand::in());
  EXPECT_LE(hand.worst_step, 0.01 + 1e-9);
  EXPECT_NEAR(hand.force(), kPush, 0.1 * kPush);
  hand.tick(Hand::over());
  EXPECT_EQ(hand.force(), 0);
  Motors motors;
  motors.give({0, 0, 0.1});
  motors.ticks(1, {0, 0, 4.9});
  EXPECT_TRUE(motors.seen & bits(Fault::kSlewLimit));
  EXPECT_LE(motors.force.z, 0.1 + 4.0 + 1e-9);
  motors.ticks(1, dvec3(0));
  EXPECT_EQ(motors.force, dvec3(0));
}

TEST(Faults, AnOverrunChangesNoForce) {
  const Scene scene = block(R"("tool": "round_010", "spindle": "air_turbine")");
  double most[2];
  for (const bool overruns : {false, true}) {
    LiveSession s(scene, load_tissue(scene));
    Paced hand(400, overruns ? 1e9 : 1e-3);  // Hz: a period that every tick outlasts, and one that none does
    Paced usual(0, 1000);
    s.serve(usual.info());
    s.wiring.patch.offer(s.carver, {0, 0, 0.7_mm});
    servo_thread(s, hand);
    most[overruns] = hand.most;
    EXPECT_EQ((s.faults & bits(Fault::kOverrun)) != 0, overruns);
  }
  EXPECT_GT(most[0], 0.05);
  EXPECT_EQ(most[0], most[1]);
}

TEST(Faults, AfterAZeroForceFaultTheHandFeelsNothingUntilItIsFree) {
  Motors motors;
  motors.give({0, 0, 1});
  motors.t += 3'000'000;  // the servo was away
  motors.safe->watch(motors.t);
  EXPECT_EQ(motors.force, dvec3(0)) << "by the watchdog";
  motors.ticks(1, {0, 0, 1});
  EXPECT_TRUE(motors.seen & bits(Fault::kLetGo));
  EXPECT_EQ(motors.force, dvec3(0));
  motors.expect_back_only_when_free({0, 0, 1});

  Hand hand(block());
  hand.press();
  const double ledger = hand.tick_.energy;
  hand.tick(Hand::in() + dvec3(0, 0, 0.1_mm), 0, bits(Fault::kLetGo));
  EXPECT_EQ(hand.tick_.energy, ledger);
  hand.tick(Hand::in());
  EXPECT_NE(hand.tick_.energy, ledger) << "it does otherwise";
}

TEST(Faults, AFillingWithoutRoomIsReportedAfter50MillisecondsAndNeverPushes) {
  Hand hand(block(
      R"("tool": {"shape": "round_end_cylinder", "diameter_mm": 1, "length_mm": 3, "cuts": false,
                  "fill": {"tissue": "composite", "rate_mm3_per_s": 2, "reach_mm": 0.6}})"));
  int said_after = -1;
  for (int i = 0; i < 200; ++i) {  // far above the block: there is nothing to put it on
    hand.tick({0, 0, 5.0_mm}, 1);
    EXPECT_EQ(hand.force(), 0);
    if (hand.has(Fault::kNoRoom) && said_after < 0) said_after = i;
  }
  EXPECT_NEAR(said_after, 50, 2) << "ms";
  for (const double v : hand.tick_.removed) EXPECT_EQ(v, 0) << "nothing was put down";
}

}  // namespace
}  // namespace typodont
