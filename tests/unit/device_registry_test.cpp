// Tests how a device is found, listed and opened by its address, and how it is mounted on the bench.
#include <gmock/gmock.h>

#include <memory>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "haptics/devices.h"
#include "haptics/devices/mounted_device.h"
#include "tests/support/folder.h"

namespace typodont::haptics {
namespace {

TEST(Registry, AnUnknownAddressIsRefusedWithTheListOfKnownOnes) {
  for (const char* bad : {"", "nonsense", "nonsense:", "WOODENHAPTICS:"}) {
    const std::string said = test::refusal([&] { open_hand(bad, {}); });
    for (const char* known :
         {"circle:", "forcedimension:", "haply:", "openhaptics:", "script:", "spacemouse:", "woodenhaptics:"}) {
      EXPECT_THAT(said, testing::HasSubstr(known));
    }
  }
}

TEST(Registry, AbsentHardwareIsAnError) {
  for (const char* address : {"woodenhaptics:", "woodenhaptics:SERIAL", "spacemouse:", "woodenhaptics:/dev/none"}) {
    EXPECT_THROW(open_hand(address, {}), Error) << address;
  }
}

TEST(Registry, TheSampleDriverIsOneFileAndCanBeOpened) {
  HandOptions options;
  options.paced = false;
  options.X_WH = {{0, 0, 1}, dquat(1, 0, 0, 0)};
  auto hand = open_hand("circle:20", options);
  HandSample sample;
  for (int i = 0; i < 251; ++i) ASSERT_TRUE(hand->read(sample));
  EXPECT_LT(glm::length(sample.X_WT.p - dvec3(0, 0.020, 1)), 1e-9);
  EXPECT_THROW(open_hand("circle:wide", options), Error);
}

TEST(Registry, DriversOfOtherModulesCanBeAdded) {
  Driver mine;
  mine.scheme = "unit-test";
  mine.hardware = false;
  mine.open = [](const std::string& rest, const HandOptions& options) { return open_hand("circle:" + rest, options); };
  add_driver(mine);
  EXPECT_NE(open_hand("unit-test:5", {}), nullptr);
}

TEST(DeviceWatch, ReportsConnectedAndDisconnectedDevices) {
  std::vector<FoundDevice> there;
  DeviceWatch watch([&] { return there; });
  EXPECT_TRUE(watch.look().empty());
  there.push_back({"woodenhaptics:12", "force feedback", "Woody", "12", "/dev/hidraw0", 5, false, "udev"});
  auto changes = watch.look();
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_TRUE(changes[0].arrived);
  EXPECT_TRUE(watch.look().empty());
  there[0].permitted = true;  // the rules now apply
  EXPECT_EQ(watch.look().size(), 2u);
  there.clear();
  changes = watch.look();
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_FALSE(changes[0].arrived);
}

TEST(Mounting, PowerIsTheSameInTheWorkbenchAndInTheBase) {
  // A device that rotates by ω and moves by v receives the power f·v + τ·ω. This number must be the same in every frame
  // and for every reference point.
  struct Moving : HapticDevice {
    DeviceInfo info_;
    HandSample now_;
    dvec3 f{0}, tau{0};
    const DeviceInfo& info() const noexcept override { return info_; }
    bool read(HandSample& s) noexcept override { return s = now_, true; }
    void write(const dvec3& force, const dvec3& torque) noexcept override { f = force, tau = torque; }
  };
  auto owned = std::make_unique<Moving>();
  Moving& inner = *owned;
  const Pose X_WH{{0.1, 0.2, 0.3}, glm::normalize(dquat(0.5, 0.1, -0.7, 0.3))};
  const Pose X_ST{{0.02, -0.01, 0.09}, glm::normalize(dquat(0.9, 0.2, 0.1, -0.4))};
  auto device = mount(std::move(owned), X_WH, X_ST);
  const Pose X_HS{{0.04, -0.03, 0.02}, glm::normalize(dquat(0.3, 0.4, 0.1, 0.8))};
  inner.now_.X_WT = X_HS;
  HandSample sample;
  device->read(sample);
  const Pose before = sample.X_WT;
  const dvec3 f(1, -2, 0.5), tau(0.01, 0.02, -0.03);
  device->write(f, tau);

  const double h = 1e-6;
  const dvec3 v_H(0.1, 0.05, -0.2), w_H(1, -2, 0.5);
  inner.now_.X_WT = {X_HS.p + h * v_H,
                     glm::normalize(dquat(1, 0.5 * h * w_H.x, 0.5 * h * w_H.y, 0.5 * h * w_H.z) * X_HS.R)};
  device->read(sample);
  const dvec3 v_T = (sample.X_WT.p - before.p) / h;
  const double at_tool = glm::dot(f, v_T) + glm::dot(tau, X_WH.R * w_H);
  const double at_device = glm::dot(inner.f, v_H) + glm::dot(inner.tau, w_H);
  EXPECT_NEAR(at_tool, at_device, 1e-6);
}

}  // namespace
}  // namespace typodont::haptics
