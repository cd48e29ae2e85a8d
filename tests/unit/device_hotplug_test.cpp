// Tests devices that are unplugged and connected again, and the second process, which switches off the force when our
// process no longer can.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <thread>

#include "engine/base/error.h"
#include "engine/contract/contact.h"
#include "engine/contract/safety_event.h"
#include "haptics/devices/reconnecting.h"
#include "haptics/devices/watchdog_process.h"
#include "tests/support/no_alloc.h"

namespace typodont::haptics {
namespace {

using namespace std::chrono_literals;

/// A device at position `x` that gives one sample per millisecond of its own time, until it is unplugged.
struct Plug {
  std::atomic<bool> in{true};
  std::atomic<double> x{0};
  std::atomic<bool> moving{false};  // true: a hand moves it by a millimetre per sample
  std::atomic<int> opened{0}, alive{0};
  std::string serial = "A1";
  bool counts_from_rest = false;
};
class Plugged : public HapticDevice {
 public:
  explicit Plugged(Plug& plug) : plug_(plug) {
    if (!plug.in) throw Error("plug:", "", "no such device plugged in", "one");
    info_ = {"plug:", "plug", plug.serial};
    info_.counts_from_rest = plug.counts_from_rest;
    ++plug.opened, ++plug.alive;
  }
  ~Plugged() override { --plug_.alive; }
  const DeviceInfo& info() const noexcept override { return info_; }
  bool read(HandSample& sample) noexcept override {
    if (!plug_.in) return false;
    if (plug_.moving) plug_.x = plug_.x + 1e-3;
    sample = {t_ += 1'000'000, {dvec3(plug_.x.load(), 0, 0), {1, 0, 0, 0}}, 1};
    return true;
  }
  void write(const dvec3& f, const dvec3&) noexcept override { force = f; }
  dvec3 force{0};

 private:
  Plug& plug_;
  DeviceInfo info_;
  Nanos t_ = 50'000'000'000;
};

struct Bench {
  Plug plug;
  std::atomic<Nanos> time{1'000'000'000};
  std::unique_ptr<ReconnectingDevice> hand;

  explicit Bench(bool counts_from_rest = false) {
    plug.counts_from_rest = counts_from_rest;
    ReconnectingDevice::Options options;
    options.clock = [this] { return time.load(); };
    options.sleep_until = [this](Nanos t) {
      time = t;
      std::this_thread::sleep_for(200us);  // the thread that opens the device again runs in real time
    };
    options.retry = 2ms;
    options.rest = 20'000'000;
    hand = std::make_unique<ReconnectingDevice>(
        std::make_unique<Plugged>(plug), [this] { return std::make_unique<Plugged>(plug); }, options);
  }
  /// Reads samples until the device is there or a second has passed. Returns their number.
  int samples_until_back() {
    HandSample sample;
    for (int i = 0; i < 20'000; ++i) {
      EXPECT_TRUE(hand->read(sample));
      if (hand->faults() == 0) return i;
    }
    return -1;
  }
};

TEST(Reconnecting, TimeCountsFromTheFirstSampleAndGoesOnAcrossTheGap) {
  Bench bench;
  HandSample sample;
  ASSERT_TRUE(bench.hand->read(sample));
  EXPECT_EQ(sample.t, 0);
  ASSERT_TRUE(bench.hand->read(sample));
  EXPECT_EQ(sample.t, 1'000'000);
  bench.plug.x = 0.5;
  ASSERT_TRUE(bench.hand->read(sample));
  bench.plug.in = false;
  Nanos last = sample.t;
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(bench.hand->read(sample));
    EXPECT_EQ(bench.hand->faults(), bits(Fault::kDeviceLost));
    EXPECT_EQ(sample.X_WT.p.x, 0.5);  // its last known position
    EXPECT_EQ(sample.pedal, 0);       // and the pedal is released
    EXPECT_GT(sample.t, last);
    last = sample.t;
    bench.hand->write({1, 0, 0}, dvec3(0));
  }
  EXPECT_GT(last, 90'000'000);
  EXPECT_NE(bench.hand->safety().events & bits(SafetyEvent::kDeviceLost), 0u);
  bench.plug.in = true;
  ASSERT_GE(bench.samples_until_back(), 0);
  ASSERT_TRUE(bench.hand->read(sample));
  EXPECT_GT(sample.t, last);
  EXPECT_EQ(sample.pedal, 1);
  EXPECT_EQ(bench.plug.opened, 2);
}

TEST(Reconnecting, TheLostDeviceIsClosedAndNoSampleAllocates) {
  Bench bench;
  HandSample sample;
  ASSERT_TRUE(bench.hand->read(sample));
  {
    const typodont::test::NoAlloc guard;
    bench.plug.in = false;
    for (int i = 0; i < 50; ++i) bench.hand->read(sample);
    EXPECT_EQ(guard.count(), 0u);
  }
  for (int i = 0; i < 2000 && bench.plug.alive > 0; ++i) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(bench.plug.alive, 0);
}

TEST(Reconnecting, AnotherDeviceOfTheSameModelIsNotReconnected) {
  Bench bench;
  HandSample sample;
  ASSERT_TRUE(bench.hand->read(sample));
  bench.plug.in = false;
  bench.hand->read(sample);
  bench.plug.serial = "B2";
  bench.plug.in = true;
  for (int i = 0; i < 200; ++i) {
    bench.hand->read(sample);
    ASSERT_EQ(bench.hand->faults(), bits(Fault::kDeviceLost));
  }
  EXPECT_GT(bench.plug.opened, 1);
  EXPECT_LE(bench.plug.alive, 1);
}

TEST(Reconnecting, AnArmWithRelativeEncodersIsReconnectedOnlyAtItsHomePosition) {
  Bench bench(true);
  HandSample sample;
  ASSERT_TRUE(bench.hand->read(sample));
  bench.plug.in = false;
  bench.hand->read(sample);
  bench.plug.moving = true;
  bench.plug.in = true;
  for (int i = 0; i < 300; ++i) {
    bench.hand->read(sample);
    ASSERT_EQ(bench.hand->faults(), bits(Fault::kDeviceLost));  // a hand holds it
  }
  EXPECT_GT(bench.plug.opened, 1);
  bench.plug.moving = false;
  EXPECT_GE(bench.samples_until_back(), 0);
}

/// Both ends of a pipe that replaces a device.
struct Wire {
  int ends[2];
  Wire() { EXPECT_EQ(::pipe(ends), 0); }
  ~Wire() { ::close(ends[0]), ::close(ends[1]); }
  /// Returns what was written within `ms` milliseconds.
  std::string read(int ms) const {
    pollfd waiting{ends[0], POLLIN, 0};
    if (::poll(&waiting, 1, ms) <= 0) return "";
    char buffer[64];
    const ssize_t n = ::read(ends[0], buffer, sizeof buffer);
    return {buffer, n > 0 ? static_cast<std::size_t>(n) : 0};
  }
};
constexpr std::array<std::uint8_t, 3> kZero{'[', '0', ']'};

TEST(WatchdogProcess, IsSilentWithoutForceAndEndsWithItsDevice) {
  const Wire wire;
  pid_t child = 0;
  {
    WatchdogProcess watchdog(wire.ends[1], kZero);
    ASSERT_TRUE(watchdog.running());
    child = watchdog.child();
    watchdog.note_write(false, now());
    EXPECT_EQ(wire.read(100), "");
    EXPECT_EQ(::kill(child, 0), 0);
  }
  EXPECT_EQ(::kill(child, 0), -1);  // the process has ended and was waited for
}

TEST(WatchdogProcess, DoesNotStartWithoutADescriptor) {
  WatchdogProcess watchdog(-1, kZero);
  EXPECT_FALSE(watchdog.running());
  watchdog.note_write(true, now());
}

}  // namespace
}  // namespace typodont::haptics
