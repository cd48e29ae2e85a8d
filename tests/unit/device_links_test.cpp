// Tests devices on emulated links and on a pseudo-terminal.
#include <gmock/gmock.h>
#include <pty.h>

#include <cmath>
#include <deque>
#include <filesystem>
#include <fstream>

#include "engine/base/error.h"
#include "engine/base/realtime.h"
#include "engine/base/units.h"
#include "engine/contract/contact.h"
#include "haptics/devices.h"
#include "haptics/devices/fd_link.h"
#include "haptics/devices/hid.h"
#include "haptics/devices/mounted_device.h"
#include "haptics/devices/pedal.h"
#include "haptics/devices/safe_device.h"
#include "haptics/devices/spacemouse.h"
#include "haptics/devices/woodenhaptics.h"
#include "tests/support/emulation/emulated_arm.h"
#include "tests/support/emulation/sim_time.h"
#include "tests/support/folder.h"

namespace typodont::haptics {
namespace {

TEST(SerialArm, APortWithoutValidAnswersIsRefusedByName) {
  int master, slave;
  char name[128];
  ASSERT_EQ(::openpty(&master, &slave, name, nullptr, nullptr), 0);
  const Descriptor keep(master), keep_slave(slave);
  auto link = open_serial(name);
  EXPECT_THROW(greet_arm(*link, true, name), Error);
}

TEST(HidArm, TheCalibrationButtonHomesTheArmAndTheJumpIsAFault) {
  test::SimTime time;
  const Arm arm = read_arm("assets/devices/woody.json");
  test::EmulatedArm board(time, ArmProtocol::kHidV2, arm, 1);
  board.hand = [](double t) { return dvec3(0.1 * std::min(1.0, t - 1), 0, kPi / 2); };  // moves aside within a second
  auto link = board.connect();
  const ArmHello hello = greet_arm(*link, false, "test");
  auto device = make_arm_device(std::move(link), hello.protocol, arm, {});
  const dvec3 home = stylus_pose(arm, arm.home).p;
  HandSample sample;
  for (int i = 0; i < 1200; ++i) {
    ASSERT_TRUE(device->read(sample));
    ASSERT_EQ(device->faults(), 0u);
    device->write(dvec3(0), dvec3(0));
  }
  EXPECT_GT(std::abs(sample.X_WT.p.y - home.y), 0.02);
  board.button = true;
  ASSERT_TRUE(device->read(sample));
  EXPECT_EQ(device->faults(), bits(Fault::kBadInput));
  EXPECT_LT(glm::length(sample.X_WT.p - home), 1e-12);
  device->write(dvec3(0), dvec3(0));
  ASSERT_TRUE(device->read(sample));  // the button is still pressed, but does not cause another fault
  EXPECT_EQ(device->faults(), 0u);
}

TEST(HidArm, JointAnglesAreCorrectForEveryProtocolAndPassEveryLayer) {
  const Arm woody = read_arm("assets/devices/woody.json"), polhem = read_arm("assets/devices/polhem_v3.json");
  struct Case {
    const Arm& arm;
    ArmProtocol protocol;
    std::size_t joints;
  };
  for (const Case& c :
       {Case{woody, ArmProtocol::kHidV1, 3}, Case{woody, ArmProtocol::kText, 3}, Case{polhem, ArmProtocol::kHidV2, 6},
        Case{polhem, ArmProtocol::kRawHid, 6}, Case{polhem, ArmProtocol::kText, 6}}) {
    test::SimTime time;
    test::EmulatedArm board(time, c.protocol, c.arm, 1);
    const dvec3 home = body_angles(c.arm, c.arm.home), stylus_home = stylus_angles(c.arm, c.arm.home);
    const auto swing = [](double t) { return 0.2 * std::sin(std::max(0.0, t - 1.2)); };
    board.hand = [&](double t) { return home + dvec3(swing(t), 0.5 * swing(t), -swing(t)); };
    board.stylus = [&](double t) { return stylus_home + dvec3(-swing(t), swing(t), 2 * swing(t)); };
    auto link = board.connect();
    Link& clock = *link;
    const ArmHello hello = greet_arm(*link, c.protocol == ArmProtocol::kText, "test");
    auto device = make_arm_device(std::move(link), hello.protocol, c.arm, {});
    EXPECT_TRUE(device->joints().empty());  // before the first sample there are none
    auto options = SafeDevice::options_for(device->info());
    options.watchdog_thread = false;
    options.clock = [&clock] { return clock.now(); };
    auto pedalled = with_pedal(std::move(device), std::make_unique<Pedal>(board.connect(), PedalKind{}));
    const auto hand = mount(std::make_unique<SafeDevice>(std::move(pedalled), options), {}, {});
    HandSample sample;
    for (int i = 0; i < 1000; ++i) {
      ASSERT_TRUE(hand->read(sample));
      hand->write(dvec3(0), dvec3(0));
    }
    ASSERT_EQ(hand->joints().size(), c.joints);
    const dvec3 bodies = board.hand(to_seconds(time.true_now())), stylus = board.stylus(to_seconds(time.true_now()));
    for (std::size_t i = 0; i < c.joints; ++i) {
      const double truth = i < 3 ? bodies[static_cast<int>(i)] : stylus[static_cast<int>(i) - 3];
      EXPECT_NEAR(hand->joints()[i], truth, 2 * kPi / 1024 + 1e-3) << i;  // one count and the motion of one millisecond
    }
  }
}

TEST(Haply, OnlyOneProgramAtATimeUsesTheService) {
  {
    const Descriptor mine = claim("haply-test", "the service");
    EXPECT_THAT(test::refusal([&] { claim("haply-test", "the service"); }),
                testing::HasSubstr("another program holds this device"));
  }
  claim("haply-test", "the service");
}

/// A link with reports that arrive at given times.
class ReportLink : public Link {
 public:
  explicit ReportLink(test::SimTime& time) : time_(time) {}
  std::deque<std::pair<Nanos, std::vector<std::uint8_t>>> reports;  // rising times
  bool gone = false;
  int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept override {
    const Nanos end = time_.now() + timeout;
    if (gone) return -1;
    if (reports.empty() || reports.front().first > end) {
      time_.advance(timeout);
      return 0;
    }
    time_.advance(std::max<Nanos>(0, reports.front().first - time_.now()));
    const auto bytes = reports.front().second;
    reports.pop_front();
    std::copy(bytes.begin(), bytes.end(), buffer.begin());
    return static_cast<int>(bytes.size());
  }
  bool write(std::span<const std::uint8_t>) noexcept override { return true; }
  Nanos now() noexcept override { return time_.now(); }

 private:
  test::SimTime& time_;
};

std::vector<std::uint8_t> full_right() {
  return {1, 0x5e, 0x01, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
}

TEST(SpaceMouse, RateControlMovesAtItsSpeedAndStopsWhenTheReportsEnd) {
  test::SimTime time;
  auto link = std::make_unique<ReportLink>(time);
  for (int i = 0; i < 100; ++i) link->reports.push_back({time.now() + i * 10'000'000, full_right()});
  auto device = make_spacemouse(std::move(link), {}, 1000, {});
  HandSample sample;
  Nanos last = 0;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(device->read(sample));
    if (last) {
      ASSERT_EQ(sample.t - last, 1'000'000);  // regular samples at 1 kHz from a mouse of 100 Hz
    }
    last = sample.t;
  }
  EXPECT_NEAR(sample.X_WT.p.x, 0.05 * (1 - 0.02), 5e-4);  // one second at full speed, less the lag of the smoothing
  for (int i = 0; i < 400; ++i) device->read(sample);
  const double rest = sample.X_WT.p.x;
  for (int i = 0; i < 1000; ++i) device->read(sample);
  EXPECT_NEAR(sample.X_WT.p.x, rest, 1e-6);
}

TEST(SpaceMouse, AFloodOfReportsDelaysNoSampleByAMillisecond) {
  test::SimTime time;
  auto link = std::make_unique<ReportLink>(time);
  for (int i = 0; i < 20'000; ++i) link->reports.push_back({time.now() + i * 10'000, full_right()});
  auto device = make_spacemouse(std::move(link), {}, 1000, {});
  HandSample sample;
  for (int i = 0; i < 100; ++i) {
    const Nanos before = time.now();
    ASSERT_TRUE(device->read(sample));
    ASSERT_LT(time.now() - before, 2'000'000);
  }
}

TEST(SpaceMouse, PositionControlReturnsToItsStart) {
  test::SimTime time;
  auto link = std::make_unique<ReportLink>(time);
  link->reports.push_back({time.now() + 1'000'000, full_right()});
  link->reports.push_back({time.now() + 150'000'000, {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}});
  SpaceMouseControl control;
  control.rate_control = false;
  auto device = make_spacemouse(std::move(link), control, 1000, {});
  HandSample sample;
  for (int i = 0; i < 140; ++i) device->read(sample);
  EXPECT_NEAR(sample.X_WT.p.x, control.reach, 1e-3);
  for (int i = 0; i < 500; ++i) device->read(sample);
  EXPECT_NEAR(sample.X_WT.p.x, 0, 1e-6);
}

TEST(Pedal, UnpluggingAFootSwitchReleasesIt) {
  test::SimTime time;
  auto link = std::make_unique<ReportLink>(time);
  ReportLink& wire = *link;
  Pedal pedal(std::move(link), *pedal_kind(0x05f3, 0x00ff, {}));
  EXPECT_EQ(pedal.value(), 0);
  wire.reports.push_back({time.now(), {2, 0}});
  EXPECT_EQ(pedal.value(), 1);
  EXPECT_EQ(pedal.value(), 1);  // without a new report the pedal is still down
  wire.gone = true;
  EXPECT_EQ(pedal.value(), 0);
  EXPECT_TRUE(pedal.lost());
}

TEST(Hid, TheReportDescriptorIsReadFromSysfs) {
  const test::Folder sys;
  const auto device = sys / "class/hidraw/hidraw7/device";
  std::filesystem::create_directories(device);
  std::ofstream(device / "report_descriptor", std::ios::binary) << "\x05\x01";
  EXPECT_EQ(report_descriptor("/dev/hidraw7", sys.path().string()), (std::vector<std::uint8_t>{5, 1}));
  EXPECT_TRUE(report_descriptor("/dev/hidraw8", sys.path().string()).empty());
}

}  // namespace
}  // namespace typodont::haptics
