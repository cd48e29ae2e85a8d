#include "haptics/device_safety.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <random>
#include <thread>

#include "engine/contract/contact.h"
#include "haptics/devices/safe_device.h"
#include "tests/support/no_alloc.h"

namespace typodont::haptics {
namespace {

/// A device that carries out every command and stores it, with one sample per millisecond.
struct Told {
  Nanos t = 0;
  HandSample next{0, {}, 0};
  bool alive = true;
  std::uint32_t faults = 0;
  dvec3 force{0}, torque{0};
  int writes = 0;
  std::function<void()> before_write;
};
class Obedient : public HapticDevice {
 public:
  Obedient(Told& told, DeviceInfo info) : told_(told), info_(std::move(info)) {}
  const DeviceInfo& info() const noexcept override { return info_; }
  bool read(HandSample& sample) noexcept override {
    told_.t += 1'000'000;
    sample = told_.next;
    sample.t = told_.t;
    return told_.alive;
  }
  void write(const dvec3& f, const dvec3& tau) noexcept override {
    if (told_.before_write) told_.before_write();
    told_.force = f, told_.torque = tau;
    ++told_.writes;
  }
  void release() noexcept override { told_.force = told_.torque = dvec3(0); }
  std::uint32_t faults() const noexcept override { return told_.faults; }

 private:
  Told& told_;
  DeviceInfo info_;
};

class Safety : public testing::Test {
 protected:
  Safety() : hand(open()) {}
  std::unique_ptr<SafeDevice> open() {
    DeviceInfo info;
    info.force_limit = 5;
    info.torque_limit = 0.1;
    info.continuous_force = 2;
    auto options = SafeDevice::options_for(info);
    options.watchdog_thread = false;
    options.clock = [this] { return told.t; };
    return std::make_unique<SafeDevice>(std::make_unique<Obedient>(told, info), options);
  }
  void ticks(int n, const dvec3& f, const dvec3& tau = dvec3(0)) {
    for (int i = 0; i < n; ++i) {
      alive = hand->read(sample);
      hand->write(f, tau);
    }
  }
  void arm() {
    ticks(80, dvec3(0));
    ASSERT_TRUE(hand->armed());
    ticks(300, {0, 0, 0.01});  // until the ramp has ended
  }
  Told told;
  std::unique_ptr<SafeDevice> hand;
  HandSample sample;
  bool alive = true;
};

TEST_F(Safety, NoForceBeforeTheHandWasFree) {
  ticks(500, {0, 0, 3});
  EXPECT_EQ(told.writes, 0);
  EXPECT_EQ(told.force, dvec3(0));
}

TEST_F(Safety, AHandInTissueWithoutForceDoesNotCountAsFree) {
  // contact(true) means that the hand is deep in tissue, or that there is no field yet, or that the force factor is
  // zero. Then there is no force, but the hand is not free.
  hand->contact(true);
  ticks(500, dvec3(0));
  EXPECT_FALSE(hand->armed());
  hand->contact(false);
  ticks(80, dvec3(0));
  EXPECT_TRUE(hand->armed());
  hand->contact(true);  // the normal case
  ticks(300, {0, 0, 2});
  EXPECT_DOUBLE_EQ(told.force.z, 2);
}

TEST_F(Safety, ForceRampsInSmoothlyOnceArmed) {
  while (!hand->armed()) ticks(1, dvec3(0));
  double last = 0;
  for (int i = 0; i < 400; ++i) {
    ticks(1, {0, 0, 2});
    ASSERT_GE(told.force.z, last);
    ASSERT_LE(told.force.z - last, 0.02);
    last = told.force.z;
  }
  EXPECT_DOUBLE_EQ(last, 2);
}

TEST_F(Safety, ForceAndTorqueNeverExceedTheirLimitsForAnyInput) {
  std::mt19937 random(1);
  std::cauchy_distribution<double> wild(0, 5);
  arm();
  for (int i = 0; i < 20'000; ++i) {
    if (random() % 50 == 0) ticks(80, dvec3(0));
    ticks(1, {wild(random), wild(random), wild(random)}, {wild(random), 0, wild(random)});
    ASSERT_LE(glm::length(told.force), 5 * (1 + 1e-12));
    ASSERT_LE(glm::length(told.torque), 0.1 * (1 + 1e-12));
  }
  EXPECT_GT(told.writes, 10'000);
}

TEST_F(Safety, APoseThatIsNotFiniteIsReplacedByTheLastGoodOne) {
  told.next.X_WT.p = {0.01, 0.02, 0.03};
  arm();
  told.next.X_WT.p.y = std::nan("");
  EXPECT_TRUE(hand->read(sample));
  EXPECT_EQ(sample.X_WT.p, dvec3(0.01, 0.02, 0.03));
  EXPECT_TRUE(hand->faults() & typodont::bits(Fault::kBadInput));
}

TEST_F(Safety, TheWatchdogSendsZeroWhenTheServoIsSilent) {
  arm();
  ticks(5, {0, 0, 3});
  ASSERT_GT(told.force.z, 0);
  const Nanos wrote = told.t;
  EXPECT_GT(hand->watch(wrote + 1'000'000), wrote + 1'000'000);
  EXPECT_GT(told.force.z, 0);  // one late tick does not count as silence
  hand->watch(wrote + 1'800'000);
  EXPECT_EQ(told.force, dvec3(0));
  told.t += 10'000'000;
  ticks(1, {0, 0, 3});
  EXPECT_EQ(told.force, dvec3(0));
}

TEST_F(Safety, ALateServoIsInformedThatTheForceWasSwitchedOff) {
  arm();
  ticks(5, {0, 0, 3});
  EXPECT_EQ(hand->faults() & typodont::bits(Fault::kLetGo), 0u);
  told.t += 10'000'000;
  ASSERT_TRUE(hand->read(sample));
  EXPECT_NE(hand->faults() & typodont::bits(Fault::kLetGo), 0u);
  hand->write({0, 0, 3}, dvec3(0));
  EXPECT_EQ(told.force, dvec3(0));
  ticks(1, {0, 0, 3});
  EXPECT_EQ(hand->faults() & typodont::bits(Fault::kLetGo), 0u);  // said once
}

TEST_F(Safety, ADelayBeforeAReadingIsReportedAsTheWatchdogsAndNotOnlyAsTheClocks) {
  arm();
  ticks(100, {0, 0, 2});
  hand->take_events();
  told.t += 300'000'000;  // the process is stopped, and the watchdog's thread runs later than the servo's
  hand->read(sample);
  EXPECT_TRUE(hand->take_events() & bits(SafetyEvent::kWatchdog));
  EXPECT_FALSE(hand->armed());
  EXPECT_EQ(told.force, dvec3(0));
  hand->write({0, 0, 2}, dvec3(0));
  EXPECT_EQ(told.force, dvec3(0));
}

TEST_F(Safety, AWatchdogThatFiresDuringAWriteSendsTheLastForce) {
  arm();
  told.before_write = [this] { hand->watch(told.t + 5'000'000); };  // the servo was stopped inside the write
  ticks(1, {0, 0, 3});
  EXPECT_EQ(told.force, dvec3(0));
}

TEST_F(Safety, AForceWrittenAfterTheWatchdogFiredIsReplacedByZero) {
  arm();
  ticks(5, {0, 0, 3});
  hand->watch(told.t + 2'000'000);
  told.force = {0, 0, 3};  // as if the servo had been stopped just before its write reached the device
  hand->watch(told.t + 3'000'000);
  EXPECT_EQ(told.force, dvec3(0));
}

TEST_F(Safety, AnEmergencyStopGivesZeroForceAtTheNextWriteUntilItEnds) {
  arm();
  ticks(20, {0, 0, 3});
  set_emergency_stop(true);
  ticks(1, {0, 0, 3});
  EXPECT_EQ(told.force, dvec3(0));
  ticks(500, dvec3(0));
  EXPECT_FALSE(hand->armed());
  set_emergency_stop(false);
  ticks(100, dvec3(0));
  EXPECT_TRUE(hand->armed());
}

TEST_F(Safety, ADeviceOpenedDuringAnEmergencyStopGivesNoForce) {
  set_emergency_stop(true);
  hand = open();
  ticks(200, dvec3(0));
  EXPECT_FALSE(hand->armed());
  set_emergency_stop(false);
  ticks(100, dvec3(0));
  EXPECT_TRUE(hand->armed());
}

TEST_F(Safety, ItsReportListsItsInterventionsAndTheMotorsLimit) {
  arm();
  hand->safety();
  ticks(2000, {0, 0, 4});  // twice the force that the motors can give permanently
  SafetyStatus status = hand->safety();
  EXPECT_TRUE(status.gives_force && status.armed);
  EXPECT_GT(status.heat, 0.1);
  EXPECT_EQ(status.bearable_force, 5);
  EXPECT_EQ(status.events, 0u);
  ticks(60'000, {0, 0, 4});
  status = hand->safety();
  EXPECT_LT(status.bearable_force, 4);
  EXPECT_GE(status.bearable_force, 2);
  EXPECT_EQ(status.events, bits(SafetyEvent::kThermal));
  EXPECT_EQ(hand->safety().events, 0u);  // said once
}

TEST_F(Safety, TheEmergencyKeyStopsTheDrillUntilThePedalWasReleased) {
  arm();
  told.next.pedal = 1;
  ticks(1, dvec3(0));
  EXPECT_EQ(sample.pedal, 1);
  set_emergency_stop(true);
  ticks(1, dvec3(0));
  EXPECT_EQ(sample.pedal, 0);
  set_emergency_stop(false);
  ticks(200, dvec3(0));
  EXPECT_EQ(sample.pedal, 0);
  told.next.pedal = 0;
  ticks(1, dvec3(0));
  told.next.pedal = 1;
  ticks(1, dvec3(0));
  EXPECT_EQ(sample.pedal, 1);
}

TEST_F(Safety, APedalPressedAtTheStartDoesNotStartTheDrill) {
  told.next.pedal = 1;
  ticks(500, dvec3(0));
  EXPECT_EQ(sample.pedal, 0);
}

TEST_F(Safety, APedalStuckForTwoMinutesStopsTheDrill) {
  arm();
  told.next.pedal = 0.7;
  ticks(119'000, dvec3(0));
  EXPECT_EQ(sample.pedal, 0.7);
  ticks(2000, dvec3(0));
  EXPECT_EQ(sample.pedal, 0);
  EXPECT_TRUE(hand->take_events() & bits(SafetyEvent::kPedalStuck));
}

TEST_F(Safety, WarmMotorsGetAtMostTheirLimit) {
  arm();
  ticks(60'000, {0, 0, 5});  // a minute at full force
  EXPECT_LE(hand->heat(), 1 + 1e-9);
  EXPECT_NEAR(told.force.z, 2, 0.1);
  ticks(120'000, dvec3(0));
  EXPECT_LT(hand->heat(), 0.1);
  ticks(10, {0, 0, 5});
  EXPECT_DOUBLE_EQ(told.force.z, 5);
}

TEST_F(Safety, DestructionSendsZero) {
  arm();
  ticks(5, {0, 0, 3});
  ASSERT_GT(told.force.z, 0);
  hand.reset();
  EXPECT_EQ(told.force, dvec3(0));
}

TEST_F(Safety, ATickNeverAllocates) {
  arm();
  typodont::test::NoAlloc guard;
  ticks(100, {0, 0, 7});
  hand->watch(told.t + 5'000'000);
  ticks(100, {std::nan(""), 0, 1});
  EXPECT_EQ(guard.count(), 0u);
}

TEST(SlewLimit, ADecreaseIsNeverDelayedAndTheForceNeverExceedsTheRequest) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 10'000; ++i) {
    const dvec3 last(normal(random), normal(random), normal(random)),
        wanted(normal(random), normal(random), normal(random));
    const double step = std::abs(normal(random)) * 0.3;
    const dvec3 f = limit_slew(last, wanted, step);
    ASSERT_LE(glm::length(f), glm::length(wanted) * (1 + 1e-12));
    ASSERT_EQ(limit_slew(last, dvec3(0), step), dvec3(0));
    const double shrink = std::min(1.0, glm::length(wanted) / glm::length(last));
    ASSERT_LE(glm::length(f - shrink * last), step * (1 + 1e-9));
  }
}

TEST(ThermalModel, NoHistoryOfAllowedForcesOverheatsTheMotors) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(0, 1);
  SafetyLimits limits;
  limits.continuous = 2;
  for (int run = 0; run < 20; ++run) {
    ThermalModel model;
    double want = 5;
    for (int i = 0; i < 20'000; ++i) {
      if (random() % 500 == 0) want = 6 * uniform(random);
      model.add(std::min(want, model.allowed(limits)), 0.01, limits);
      ASSERT_LE(model.heat, 1 + 1e-6);
    }
  }
}

TEST(Watchdog, ItsThreadSetsTheForceToZeroWithoutTheServo) {
  struct Shared : HapticDevice {
    DeviceInfo info_;
    std::atomic<bool>& out;
    explicit Shared(std::atomic<bool>& o) : out(o) { info_.force_limit = 5; }
    const DeviceInfo& info() const noexcept override { return info_; }
    bool read(HandSample& s) noexcept override {
      s = {now(), {}, 0};
      return true;
    }
    void write(const dvec3& f, const dvec3&) noexcept override { out = f != dvec3(0); }
    void release() noexcept override { out = false; }
  };
  std::atomic<bool> out{false};
  auto options = SafeDevice::options_for([] {
    DeviceInfo info;
    info.force_limit = 5;
    return info;
  }());
  options.limits.silence = 0.2;  // so that other work of the machine does not trigger it too early
  options.limits.ramp_in = 1e-3;
  SafeDevice hand(std::make_unique<Shared>(out), options);
  HandSample sample;
  for (int i = 0; i < 2000 && !out; ++i) {
    hand.read(sample);
    hand.write(hand.armed() ? dvec3(0, 0, 1) : dvec3(0), dvec3(0));
    if (!out) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(out);
  for (int i = 0; i < 500 && out; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_FALSE(out);
  EXPECT_TRUE(hand.take_events() & bits(SafetyEvent::kWatchdog));
}

}  // namespace
}  // namespace typodont::haptics
