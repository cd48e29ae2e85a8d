// Injects faults into the emulated arm, in simulated time. A hand presses into a wall and leaves it repeatedly, and at
// a random moment a part fails. Each kind of fault is injected 240 times, and more often in ./run stress. The force
// must never exceed the limits, must soon be zero, and may return only after the hand was free of contact.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <tuple>

#include "engine/contract/contact.h"
#include "haptics/devices/pedal.h"
#include "haptics/devices/safe_device.h"
#include "haptics/devices/woodenhaptics.h"
#include "tests/support/campaign.h"
#include "tests/support/emulation/emulated_arm.h"

namespace typodont::haptics {
namespace {

using test::EmulatedArm;
using test::SimTime;

struct Outcome {
  double worst_force = 0, worst_current = 0;  // N, A, over the whole run
  double zero_after = -1;                     // s from the breakage to zero force, -1: there was none
  bool force_before = false;                  // there was contact when it broke
  bool stayed_zero = true;                    // until the hand was free
  bool came_back = false;                     // force again in a later contact
  bool ended = false;                         // read() said the device is gone
  bool faulty = false;                        // a sample was said to be bad
  std::uint32_t trips = 0;                    // what took the force away after the breakage
  double worst_step = 0;                      // m between two samples
  double stall = 0;                           // s that the servo was away
};

/// What a breakage may change.
struct Scene {
  EmulatedArm& board;
  SimTime& time;
  std::mt19937& random;
  dvec3& force;   // N, that the servo writes next
  double& stall;  // s
  int up_to(int most) { return 1 + static_cast<int>(random() % static_cast<unsigned>(most)); }
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); }
};

/// A part that fails, and what must follow in every run.
struct Breakage {
  const char* title;
  void (*happens)(Scene);
  bool zero = true;            // the force becomes zero within two milliseconds, and stays zero until the hand is free
  bool comes_back = true;      // the force comes back in a later contact
  bool ends = false;           // read() says that the device is gone
  bool noticed = true;         // otherwise no sample is bad, and nothing takes the force away
  double longest_step = 1;     // m, between two samples
  int may_stay_off = 0;        // number of runs in which the force need not come back
  bool wraps_encoder = false;  // an encoder wraps around at this moment
  int times = test::campaign(60);
};

Outcome run(const Breakage& breakage, ArmProtocol protocol, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };

  SimTime time;
  const Arm arm = test::weightless_arm();
  EmulatedArm board(time, protocol, arm, seed);
  const double phase = uniform(0.2, 0.6), break_at = uniform(1.4, 1.8);
  // The arm moves from its home position into the wall and out of it, five times per second.
  board.hand = [&](double t) {
    const double s = std::sin(2 * 3.14159265 * (5 * (t - 1) - 0.25)) + 1;
    return dvec3(0.02 * s, 0.06 * s * (1 + 0.1 * phase), 1.5707963 + 0.01 * s);
  };
  if (breakage.wraps_encoder) board.wrap_at(1, board.hand(break_at));
  auto link = board.connect();
  const ArmHello hello = greet_arm(*link, protocol == ArmProtocol::kText, "emulated");
  EXPECT_EQ(hello.protocol, protocol);
  DeviceInfo limits;
  limits.force_limit = arm.force_limit;
  limits.continuous_force = arm.continuous_force;
  SafeDevice::Options options = SafeDevice::options_for(limits);
  options.watchdog_thread = false;
  options.clock = [&] { return time.now(); };
  SafeDevice hand(make_arm_device(std::move(link), protocol, arm, {"woodenhaptics:", "", ""}), options);
  Nanos next_watch = 0;
  Outcome out;
  bool broken = false, was_free = false;
  double broke_at = 0;

  dvec3 seen(0);
  double force = 0;
  time.on_step([&] {
    // Does the work of the watchdog's thread, which wakes at the time that it requested.
    if (time.true_now() >= next_watch) {
      const Nanos wake = hand.watch(time.now());
      next_watch = time.true_now() + std::clamp<Nanos>(wake - time.now(), SimTime::kStep, 10'000'000);
    }
    if (board.amperes() != seen || time.true_now() % 1'000'000 == 0) {
      seen = board.amperes();
      force = glm::length(board.force());
      out.worst_force = std::max(out.worst_force, force);
      for (int i = 0; i < 3; ++i) out.worst_current = std::max(out.worst_current, std::abs(seen[i]));
    }
    if (!broken) return;
    if (force < 1e-9) {
      if (out.zero_after < 0) out.zero_after = to_seconds(time.true_now()) - broke_at;
    } else if (out.zero_after >= 0) {
      (was_free ? out.came_back : out.stayed_zero) = was_free;
    }
  });

  constexpr double kWall = 0.030;  // m, H x
  double free_for = 0;
  HandSample sample;
  dvec3 before(0);
  while (to_seconds(time.true_now()) < break_at + out.stall + 0.7) {
    if (!hand.read(sample)) {
      out.ended = true;
      break;
    }
    out.faulty |= hand.faults() != 0 && to_seconds(time.true_now()) > 1.1;  // once it is awake
    if (before != dvec3(0)) out.worst_step = std::max(out.worst_step, glm::length(sample.X_WT.p - before));
    before = sample.X_WT.p;
    dvec3 f(0);
    if (sample.X_WT.p.x > kWall) f.x = -1500 * (sample.X_WT.p.x - kWall);
    // A hand counts as free here if the servo requested no force during 40 ms of good samples.
    free_for = f.x == 0 && hand.faults() == 0 ? free_for + 1e-3 : 0;
    if (broken && free_for > 0.04) was_free = true;

    if (!broken && to_seconds(time.true_now()) > break_at) {
      broken = true;
      broke_at = to_seconds(time.true_now());
      hand.take_events();
      out.force_before = glm::length(board.force()) > 0.05;
      free_for = 0;
      breakage.happens({board, time, random, f, out.stall});
    }
    hand.write(f, dvec3(0));
  }
  out.trips = hand.take_events() &
              ~(bits(SafetyEvent::kForceLimit) | bits(SafetyEvent::kSlewLimit) | bits(SafetyEvent::kThermal));
  time.advance(5'000'000);
  return out;
}

// N. Motor currents have a resolution of one milliampere, and the arm moves by half a millimetre while one current is
// set. Together this adds 1 % to the limit of 5 N.
constexpr double kPeak = 5 * 1.01;

constexpr double kTwoMilliseconds = 0.0021;  // as seen from outside, in steps of 0.1 ms

const Breakage kBreakages[] = {
    {.title = "UnpluggingInContactEndsTheLoopWithoutALatchedForce",
     .happens = [](Scene s) { s.board.unplugged = true; },
     .comes_back = false,
     .ends = true},
    {.title = "WhenTheBoardFallsSilentForceIsZeroWithinTwoMilliseconds",
     .happens = [](Scene s) { s.board.silent = true; },
     .comes_back = false,
     .ends = true},
    {.title = "ShortReportsSetTheForceToZeroUntilTheHandIsFree",
     .happens = [](Scene s) { s.board.short_reports = s.up_to(20); }},
    {.title = "OfMergedReportsTheNewestIsReadAndTheForceIsUnchanged",
     .happens = [](Scene s) { s.board.merged_reports = s.up_to(20); },
     .zero = false,
     .noticed = false},
    // In one of thousands of reports, random bytes of the right length are a possible position of the arm. The program
    // accepts this position and then rejects the true one. So the force stays off until the arm is in its home position
    // again.
    {.title = "GarbageBytesSetTheForceToZeroUntilTheHandIsFree",
     .happens = [](Scene s) { s.board.garbage_reports = s.up_to(20); },
     .may_stay_off = 4},
    {.title = "AnEncoderThatWrapsInContactIsNotFelt",
     .happens = [](Scene) {},
     .zero = false,
     .noticed = false,
     .longest_step = 2e-3,  // as far as that hand moves in a millisecond
     .wraps_encoder = true},
    {.title = "AJumpingEncoderReadingSetsTheForceToZeroUntilTheHandIsFree",
     .happens = [](Scene s) { s.board.leaping_reports = s.up_to(3); },
     .longest_step = 8e-3},  // what the hand did meanwhile
    {.title = "AnEncoderSlipSetsTheForceToZeroPermanently",
     .happens = [](Scene s) { s.board.slip[s.random() % 3] = 2000 + s.up_to(20000); },
     .comes_back = false},
    {.title = "AServoThatStallsLosesItsForceWithinTwoMillisecondsOfItsLastWrite",
     .happens = [](Scene s) { s.time.advance(from_seconds(s.stall = s.uniform(0.001, 0.5))); }},
    {.title = "AClockStepSetsTheForceToZeroUntilTheHandIsFree",
     .happens = [](Scene s) { s.time.step_clock(from_seconds(s.uniform(-5, 5))); }},
    {.title = "ANanForceBecomesZeroImmediately", .happens = [](Scene s) { s.force.y = std::nan(""); }},
    {.title = "AnAbsurdForceIsClippedToTheLimit",
     .happens =
         [](Scene s) {
           s.force = {-1e6, 3e6, 0};
         },
     .zero = false}};

const Breakage kBoardError{.title = "AnErrorOfTheBoardSetsTheForceToZeroWhileItLasts",
                           .happens = [](Scene s) { s.board.error = 3; },
                           .comes_back = false,
                           .times = test::campaign(240)};

using FaultAtArm = std::tuple<Breakage, ArmProtocol>;
class Faults : public testing::TestWithParam<FaultAtArm> {};

TEST_P(Faults, KeepTheLimitsAndHaveTheirDocumentedEffect) {
  const auto& [breakage, protocol] = GetParam();
  int in_contact = 0, stayed_off = 0;
  for (int i = 0; i < breakage.times; ++i) {
    const Outcome o = run(breakage, protocol, static_cast<std::uint32_t>(i));
    SCOPED_TRACE(testing::Message() << "run " << i << ", zero after " << 1e3 * o.zero_after << " ms, stalled "
                                    << 1e3 * o.stall << " ms, in contact: " << o.force_before);
    ASSERT_LE(o.worst_force, kPeak);
    ASSERT_LE(o.worst_current, 3.0);
    in_contact += o.force_before;
    ASSERT_EQ(o.ended, breakage.ends);
    if (breakage.comes_back) {
      stayed_off += !o.came_back;
    } else {
      ASSERT_FALSE(o.came_back);
    }
    if (!breakage.noticed) {
      ASSERT_FALSE(o.faulty);
      ASSERT_EQ(o.trips, 0u);
    }
    ASSERT_LT(o.worst_step, breakage.longest_step);
    const bool back_in_time = o.stall > 0 && o.stall < 0.0025;  // before the watchdog's patience ended
    if (!breakage.zero || back_in_time) continue;
    if (o.force_before || o.stall == 0) {
      ASSERT_GE(o.zero_after, 0);
      ASSERT_LE(o.zero_after, kTwoMilliseconds);
    }
    ASSERT_TRUE(o.stayed_zero);
  }
  EXPECT_LE(stayed_off, breakage.may_stay_off);
  EXPECT_GT(in_contact, breakage.times / 10);  // the campaign did hit contacts
}
std::string name_of_fault(const testing::TestParamInfo<FaultAtArm>& info) {
  return std::string(std::get<0>(info.param).title) + test::name_of(std::get<1>(info.param));
}
INSTANTIATE_TEST_SUITE_P(Arms, Faults,
                         testing::Combine(testing::ValuesIn(kBreakages), testing::ValuesIn(test::kArmProtocols)),
                         name_of_fault);
INSTANTIATE_TEST_SUITE_P(TextBoard, Faults,
                         testing::Combine(testing::Values(kBoardError), testing::Values(ArmProtocol::kText)),
                         name_of_fault);

/// A foot switch that sends a report whenever it is pressed or released, between two samples.
class Foot : public Link {
 public:
  explicit Foot(const bool& down) : down_(down) {}
  int read(std::span<std::uint8_t> buffer, Nanos) noexcept override {
    if (down_ == told_) return 0;
    told_ = down_;
    std::fill_n(buffer.begin(), 8, std::uint8_t{0});
    buffer[2] = told_ ? 4 : 0;
    return 8;
  }
  bool write(std::span<const std::uint8_t>) noexcept override { return true; }

 private:
  const bool& down_;
  bool told_ = false;
};

TEST(PedalStuck, TheDrillStopsAfterTheTimeLimitAndStaysOffUntilThePedalIsReleased) {
  constexpr double kLimit = 0.2005;  // s
  std::mt19937 random(5);
  SimTime time;
  const Arm arm = test::weightless_arm();
  EmulatedArm board(time, ArmProtocol::kHidV2, arm, 1);
  board.hand = [](double) { return dvec3(0, 0, 1.5707963); };
  auto link = board.connect();
  const ArmHello hello = greet_arm(*link, false, "emulated");
  bool down = false;
  auto arm_device = make_arm_device(std::move(link), hello.protocol, arm, {"woodenhaptics:", "", ""});
  SafeDevice::Options options = SafeDevice::options_for(arm_device->info());
  options.watchdog_thread = false;
  options.clock = [&] { return time.now(); };
  options.limits.pedal_time = kLimit;
  SafeDevice hand(with_pedal(std::move(arm_device), std::make_unique<Pedal>(std::make_unique<Foot>(down), PedalKind{})),
                  options);
  HandSample sample;
  const auto ticks = [&](int n, auto check) {
    for (int i = 0; i < n; ++i) {
      ASSERT_TRUE(hand.read(sample));
      hand.write(dvec3(0), dvec3(0));
      check(i);
    }
  };
  ticks(100, [](int) {});
  ASSERT_TRUE(hand.armed());
  for (int k = 0; k < test::campaign(240); ++k) {
    // The switch is pressed and released in time, zero to two times; the drill must follow immediately. Then the switch
    // sticks.
    for (int presses = static_cast<int>(random() % 3); presses > 0; --presses) {
      down = true;
      ticks(1 + static_cast<int>(random() % 190), [&](int) { ASSERT_EQ(sample.pedal, 1); });
      down = false;
      ticks(1 + static_cast<int>(random() % 50), [&](int) { ASSERT_EQ(sample.pedal, 0); });
    }
    down = true;
    ticks(201 + static_cast<int>(random() % 300),
          [&](int i) { ASSERT_EQ(sample.pedal, i < 200 ? 1 : 0) << k << " " << i; });
    ASSERT_TRUE(hand.take_events() & bits(SafetyEvent::kPedalStuck));
    down = false;
    ticks(1 + static_cast<int>(random() % 20), [&](int) { ASSERT_EQ(sample.pedal, 0); });
  }
}

}  // namespace
}  // namespace typodont::haptics
