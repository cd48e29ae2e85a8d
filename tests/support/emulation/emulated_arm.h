// A WoodenHaptics or Polhem board as its firmware behaves, in simulated time: lock-step reports, 16-bit counters, a
// 0.5 s watchdog, no clamp on currents. And everything that can go wrong with it.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "haptics/devices/arm.h"
#include "haptics/devices/arm_protocol.h"
#include "haptics/devices/link.h"
#include "tests/support/emulation/sim_time.h"

namespace typodont::test {

class EmulatedArm {
 public:
  EmulatedArm(SimTime& time, haptics::ArmProtocol protocol, haptics::Arm arm, std::uint32_t seed);

  /// Where the hand holds the arm: angles of the bodies, by true time in seconds.
  std::function<dvec3(double)> hand;
  /// Angles of the stylus' joints D, E, F; empty: as in the home position.
  std::function<dvec3(double)> stylus;

  /// A link to it; more than one may live.
  std::unique_ptr<haptics::Link> connect();

  /// Chooses what the counters showed at power-on so that encoder i of a HID board wraps as the arm passes there.
  void wrap_at(int i, const dvec3& theta);

  dvec3 amperes() const { return amperes_; }
  /// Force that the motors put on the hand now.
  dvec3 force() const;
  dvec3 theta() const;

  // What can go wrong, from now on or for the next report.
  bool unplugged = false;
  bool silent = false;  // no report whatever the host writes
  int short_reports = 0, merged_reports = 0, garbage_reports = 0;
  int leaping_reports = 0;             // all encoders somewhere else
  std::array<std::int64_t, 6> slip{};  // counts lost, for good
  int error = 0;                       // text: the board's own error
  bool refuses_writes = false;
  bool watchdog = true;  // false: a firmware that never lets go, so that whatever does was the host's doing
  bool button = false;
  double chatter = 0;  // reports a second that it sends besides, without being asked

 private:
  class Wire;
  int read(std::span<std::uint8_t> buffer, Nanos timeout);
  bool write(std::span<const std::uint8_t> bytes);
  std::vector<std::uint8_t> report();
  std::vector<std::uint8_t> broken_report();
  void talk();
  std::int64_t counts_at(int i, const dvec3& theta) const;

  SimTime& time_;
  haptics::ArmProtocol protocol_;
  haptics::Arm arm_;
  std::mt19937 random_;
  dvec3 amperes_{0};
  Nanos last_command_ = 0;
  bool spoken_to_ = false;
  std::int64_t power_on_;                          // what the counters showed in the home position
  std::deque<std::vector<std::uint8_t>> unasked_;  // reports that nobody has read yet
  double talked_ = 0;                              // reports of `chatter` that are due
};

}  // namespace typodont::test
