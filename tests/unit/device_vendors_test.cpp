// Tests devices that use their vendors' libraries, with replacements for these libraries.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include "engine/base/error.h"
#include "engine/contract/contact.h"
#include "haptics/devices.h"
#include "haptics/devices/safe_device.h"
#include "tests/support/folder.h"

namespace typodont::haptics {
namespace {

/// A replacement library that is loaded under its vendor's name before the driver asks for it.
class StandIn {
 public:
  explicit StandIn(const char* path) : handle_(::dlopen(path, RTLD_NOW | RTLD_LOCAL)) {
    EXPECT_NE(handle_, nullptr) << ::dlerror();
  }
  template <class F>
  F* get(const char* name) {
    return reinterpret_cast<F*>(::dlsym(handle_, name));
  }

 private:
  void* handle_;
};

struct OpenHaptics : testing::Test {
  StandIn library{TYPODONT_STANDIN_HD};
  bool (*const step)() = library.get<bool()>("standin_hd_step");
  const double* (*const force)() = library.get<const double*()>("standin_hd_force");
  void (*const fail)(unsigned) = library.get<void(unsigned)>("standin_hd_fail");
};
struct ForceDimension : testing::Test {
  StandIn library{TYPODONT_STANDIN_DHD};
  const double* (*const wrench)() = library.get<const double*()>("standin_dhd_wrench");
  void (*const breaks)(bool) = library.get<void(bool)>("standin_dhd_break");
  bool (*const powered)() = library.get<bool()>("standin_dhd_powered");
};

const Driver& driver(const std::string& scheme) {
  for (const Driver& d : drivers()) {
    if (d.scheme == scheme) return d;
  }
  throw Error("no driver " + scheme);
}

TEST_F(OpenHaptics, SamplesInMillimetresBecomeMetresAndForcesArriveInTheCallback) {
  library.get<void(double, double, double)>("standin_hd_place")(10, -20, 30);
  library.get<void(int)>("standin_hd_press")(1);
  auto device = driver("openhaptics").open("", {});
  EXPECT_EQ(device->info().model, "Touch (stand-in)");
  EXPECT_DOUBLE_EQ(device->info().force_limit, 3.3);
  EXPECT_DOUBLE_EQ(device->info().max_stiffness, 400);
  EXPECT_DOUBLE_EQ(device->info().continuous_force, 0.88);

  HandSample sample;
  ASSERT_TRUE(step());
  ASSERT_TRUE(device->read(sample));
  EXPECT_LT(glm::length(sample.X_WT.p - dvec3(0.010, -0.020, 0.030)), 1e-15);
  EXPECT_EQ(sample.pedal, 1);
  ASSERT_EQ(device->joints().size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_DOUBLE_EQ(device->joints()[i], 0.1 * static_cast<double>(i + 1));
  device->write({0.5, 0, -1}, dvec3(0));
  step();
  EXPECT_EQ(force()[0], 0.5);
  EXPECT_EQ(force()[2], -1);
}

TEST_F(OpenHaptics, IfTheServoStopsWritingTheForceIsZeroAfterTwoCallbacks) {
  auto device = driver("openhaptics").open("Default Device", {});
  device->write({1, 0, 0}, dvec3(0));
  for (int i = 0; i < 3; ++i) {
    step();
    EXPECT_EQ(force()[0], 1);
  }
  step();
  EXPECT_EQ(force()[0], 0);
  device->write({1, 0, 0}, dvec3(0));
  step();
  EXPECT_EQ(force()[0], 1);
  device->release();
  step();
  EXPECT_EQ(force()[0], 0);
}

TEST_F(OpenHaptics, ErrorsAreReportedAndTheEndLeavesNoForce) {
  auto device = driver("openhaptics").open("", {});
  HandSample sample;
  fail(0x0300);
  step();
  ASSERT_TRUE(device->read(sample));
  EXPECT_EQ(device->faults(), bits(Fault::kBadInput));
  EXPECT_FALSE(device->read(sample));  // no callback for 100 ms: lost
  EXPECT_EQ(device->faults(), bits(Fault::kDeviceLost));
  device->write({1, 0, 0}, dvec3(0));
  step();
  device.reset();
  EXPECT_EQ(force()[0], 0);
  EXPECT_FALSE(library.get<bool()>("standin_hd_output")());
  EXPECT_THROW(driver("openhaptics").open("Nobody", {}), Error);
}

TEST_F(OpenHaptics, ClosingOneOfTwoArmsSetsItsForceToZeroAndKeepsTheOtherRunning) {
  auto* const second_force = library.get<const double*()>("standin_hd_second_force");
  auto right = driver("openhaptics").open("", {});
  auto left = driver("openhaptics").open("Second", {});
  const auto push = [&](HapticDevice& device) {
    device.write({1, 0, 0}, dvec3(0));
    EXPECT_TRUE(step());
  };
  push(*right);
  push(*left);
  EXPECT_EQ(force()[0], 1);
  EXPECT_EQ(second_force()[0], 1);
  left.reset();
  EXPECT_EQ(second_force()[0], 0);
  for (int i = 0; i < 4; ++i) step();
  EXPECT_EQ(force()[0], 0) << "a silent servo loses its force";
  push(*right);
  EXPECT_EQ(force()[0], 1);
  HandSample sample;
  EXPECT_TRUE(right->read(sample));
  left = driver("openhaptics").open("Second", {});  // and opened again
  push(*left);
  EXPECT_EQ(second_force()[0], 1);
  right.reset();
  left.reset();
  EXPECT_FALSE(step()) << "the last one stops the scheduler";
  EXPECT_EQ(force()[0], 0);
  EXPECT_EQ(second_force()[0], 0);
}

/// Returns the safety layer around a vendor's device, with such short times that a thousand faults need little time.
std::unique_ptr<SafeDevice> hasty(std::unique_ptr<HapticDevice> device) {
  SafeDevice::Options options = SafeDevice::options_for(device->info());
  options.watchdog_thread = false;
  options.limits.silence = 100;  // in this test no thread is late
  options.limits.free_time = 1e-9;
  options.limits.ramp_in = 1e-9;
  options.limits.slew = 1e12;
  return std::make_unique<SafeDevice>(std::move(device), options);
}

/// Pushes for a random time and causes a fault, a thousand times. From the fault on, the force must be zero as long as
/// the hand is in contact. `force`: N, along z; `longest`: of a push, in ticks; `tick`: one tick with a force (N) along
/// z.
void expect_no_force_after_any_fault(SafeDevice& hand, const std::function<double()>& force, unsigned longest,
                                     const std::function<void(double)>& tick, const std::function<void()>& fault) {
  std::mt19937 random(3);
  const auto ticks = [&](unsigned n, double newton) {
    for (unsigned i = 0; i < n; ++i) tick(newton);
  };
  for (int i = 0; i < 1000; ++i) {
    // Tries again, because a delay of the machine looks like a jump of time.
    for (int tries = 0; tries == 0 || (force() != 2 && tries < 20); ++tries) {
      ticks(5, 0);
      ticks(2 + static_cast<unsigned>(random()) % longest, 2);
    }
    ASSERT_EQ(force(), 2) << i;
    fault();
    ASSERT_EQ(force(), 0) << i;
    ticks(1 + static_cast<unsigned>(random()) % longest / 2, 2);
    ASSERT_EQ(force(), 0) << i;
    ASSERT_TRUE(hand.take_events() & bits(SafetyEvent::kDeviceFault));
  }
}

TEST_F(OpenHaptics, EveryFaultAtARandomTimeSetsTheForceToZeroWithinOneCallback) {
  const auto hand = hasty(driver("openhaptics").open("", {}));
  HandSample sample;
  const auto tick = [&](double newton) {
    ASSERT_TRUE(step());
    ASSERT_TRUE(hand->read(sample));
    hand->write({0, 0, newton}, dvec3(0));
  };
  unsigned error = 0;
  expect_no_force_after_any_fault(
      *hand, [&] { return force()[2]; }, 20, tick,
      [&] {
        fail(0x0300 + error++ % 16);
        tick(2);
        step();
        EXPECT_EQ(force()[2], 0);
        ASSERT_TRUE(hand->read(sample));
      });
}

TEST_F(ForceDimension, EveryFaultAtARandomTimeSetsTheForceToZeroImmediately) {
  HandOptions options;
  options.rate = 8000;
  const auto hand = hasty(driver("forcedimension").open("0", options));
  HandSample sample;
  const auto tick = [&](double newton) {
    ASSERT_TRUE(hand->read(sample));
    hand->write({0, 0, newton}, dvec3(0));
  };
  expect_no_force_after_any_fault(
      *hand, [&] { return wrench()[2]; }, 6, tick,
      [&] {
        breaks(true);
        ASSERT_TRUE(hand->read(sample));
        EXPECT_EQ(wrench()[2], 0);
        hand->write({0, 0, 2}, dvec3(0));
        breaks(false);
      });
}

TEST_F(ForceDimension, PosesForcesAndTorquesPassThroughAndTheEndLeavesNoForce) {
  library.get<void(double, double, double)>("standin_dhd_place")(0.01, 0.02, 0.03);
  library.get<void(unsigned)>("standin_dhd_press")(1);
  auto device = driver("forcedimension").open("0", {});
  EXPECT_EQ(device->info().serial, "4711");
  EXPECT_EQ(device->info().force_limit, 12);  // by its name, a sigma
  EXPECT_EQ(library.get<unsigned char()>("standin_dhd_watchdog")(), 16);
  HandSample sample;
  ASSERT_TRUE(device->read(sample));
  EXPECT_EQ(sample.X_WT.p, dvec3(0.01, 0.02, 0.03));
  EXPECT_LT(glm::length(sample.X_WT.rotate({1, 0, 0}) - dvec3(0, 1, 0)), 1e-12);
  EXPECT_EQ(sample.pedal, 1);
  ASSERT_EQ(device->joints().size(), 6u);  // base and wrist; the grip is no joint of the pose
  for (std::size_t i = 0; i < 6; ++i) EXPECT_DOUBLE_EQ(device->joints()[i], 0.1 * static_cast<double>(i + 1));
  device->write({1, 2, 3}, {0.1, 0.2, 0.3});
  EXPECT_EQ(wrench()[2], 3);
  EXPECT_EQ(wrench()[5], 0.3);
  device->release();
  EXPECT_EQ(wrench()[2], 0);
  device->write({1, 2, 3}, {0.1, 0.2, 0.3});
  device.reset();
  for (int i = 0; i < 6; ++i) EXPECT_EQ(wrench()[i], 0);
  EXPECT_FALSE(powered());
}

TEST_F(ForceDimension, ADeviceThatStopsAnsweringGetsZeroAndIsLost) {
  auto device = driver("forcedimension").open("", {});
  HandSample sample;
  ASSERT_TRUE(device->read(sample));
  device->write({1, 2, 3}, dvec3(0));
  breaks(true);
  EXPECT_TRUE(device->read(sample));
  EXPECT_EQ(device->faults(), bits(Fault::kBadInput));
  EXPECT_EQ(wrench()[2], 0);
  for (int i = 0; i < 1000 && device->read(sample); ++i) {
  }
  EXPECT_EQ(device->faults(), bits(Fault::kDeviceLost));
  breaks(false);
}

std::vector<FoundDevice> found_by(const std::string& scheme) {
  return driver(scheme).find();
}

TEST_F(ForceDimension, IsOpenedBySerialAndListingNeitherOpensItAgainNorDisturbsIt) {
  auto* const opened = library.get<int()>("standin_dhd_opened");
  found_by("forcedimension");
  int before = opened();
  const auto list = [&] {
    for (int i = 0; i < 5; ++i) EXPECT_EQ(found_by("forcedimension").size(), 1u);
    EXPECT_EQ(opened(), before);
  };
  list();
  EXPECT_FALSE(powered()) << "a list switches no force on";
  auto device = driver("forcedimension").open("4711", {});
  EXPECT_EQ(device->info().serial, "4711");
  before = opened();
  list();
  EXPECT_TRUE(powered());
  EXPECT_THROW(driver("forcedimension").open("4712", {}), Error);
}

TEST_F(OpenHaptics, DevicesAreListedByTheirConfiguredNamesWithoutSwitchingForceOn) {
  const test::Folder folder;
  std::filesystem::create_directories(folder / "config");
  ::setenv("GTDD_HOME", folder.path().c_str(), 1);
  auto found = found_by("openhaptics");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].permitted);
  EXPECT_NE(found[0].mend.find("set-up program"), std::string::npos);
  for (const char* name : {"Default Device", "Left"})
    std::ofstream(folder / "config" / (name + std::string(".config"))) << "";
  found = found_by("openhaptics");
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].address, "openhaptics:Default Device");
  EXPECT_TRUE(found[0].permitted);
  EXPECT_FALSE(found[1].permitted) << "named, but not there";
  EXPECT_FALSE(library.get<bool()>("standin_hd_output")());
  ::unsetenv("GTDD_HOME");
}

}  // namespace
}  // namespace typodont::haptics
