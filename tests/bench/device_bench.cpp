// What the devices' code adds to a tick: from the report of an arm to the currents written, safety layer included,
// against the same loop over the same link with no work in it. The link is memory: this is our share, not USB's.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "haptics/devices/safe_device.h"
#include "haptics/devices/woodenhaptics.h"
#include "engine/contract/loop_timing.h"

namespace typodont::haptics {
namespace {

/// A board that answers at once and moves a little with every report, in a clock of one millisecond per report.
class MemoryBoard : public Link {
 public:
  int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept override {
    if (timeout == 0) return 0;
    t_ += 1'000'000;
    const auto counts = static_cast<std::uint8_t>(std::abs(t_ / 1'000'000 % 200 - 100) / 4);  // to and fro
    for (std::size_t i = 0; i < 14; ++i) buffer[i] = i < 12 && i % 2 == 0 ? counts : 0;
    return 14;
  }
  bool write(std::span<const std::uint8_t> bytes) noexcept override {
    sum_ += bytes[1];
    return true;
  }
  Nanos now() noexcept override { return t_; }

 private:
  Nanos t_ = 0;
  unsigned sum_ = 0;
};

constexpr int kTicks = 100'000;

LoopTiming bare_loop() {
  MemoryBoard board;
  LoopTiming timing;
  std::uint8_t report[64], command[15] = {};
  for (int i = 0; i < kTicks; ++i) {
    board.read(report, 1);
    const Nanos woke = now();
    board.write(command);
    timing.record(woke, now());
  }
  return timing;
}

LoopTiming arm_loop(const char* preset) {
  auto link = std::make_unique<MemoryBoard>();
  Link& clock = *link;
  auto device = make_arm_device(std::move(link), ArmProtocol::kHidV2, read_arm(preset), {});
  auto options = SafeDevice::options_for(device->info());
  options.clock = [&clock] { return clock.now(); };
  options.watchdog_thread = false;
  SafeDevice hand(std::move(device), options);
  LoopTiming timing;
  HandSample sample;
  for (int i = 0; i < kTicks; ++i) {
    const Nanos woke = now();
    hand.read(sample);
    hand.write(hand.armed() ? dvec3(0.1, 0.2, 0.3) : dvec3(0), dvec3(0));
    timing.record(woke, now());
  }
  EXPECT_TRUE(hand.armed());
  return timing;
}

TEST(DeviceBench, AnArmsTickTakesLessThanATwentiethOfAMillisecond) {
  const LoopTiming bare = bare_loop();
  fmt::print("{:<44}{:>12}{:>12}\n", "report to force written", "median ns", "p99.9 ns");
  fmt::print("{:<44}{:>12.0f}{:>12.0f}\n", "no work", bare.work.quantile(0.5), bare.work.quantile(0.999));
  for (const char* preset : {"assets/devices/woody.json", "assets/devices/polhem_v3.json"}) {
    const LoopTiming arm = arm_loop(preset);
    fmt::print("{:<44}{:>12.0f}{:>12.0f}\n", preset, arm.work.quantile(0.5), arm.work.quantile(0.999));
    EXPECT_LT(arm.work.quantile(0.5), 50e3);
  }
}

}  // namespace
}  // namespace typodont::haptics
