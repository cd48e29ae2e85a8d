// Emulates the firmware of a WoodenHaptics or Polhem board in simulated time: request-answer reports, 16-bit counters,
// no current limit. Its motors never switch off by themselves, so the host must do it. All possible errors can be
// injected.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "haptics/devices/arm.h"
#include "haptics/devices/arm_protocol.h"
#include "haptics/devices/link.h"
#include "tests/support/emulation/sim_time.h"

namespace typodont::test {

class EmulatedArm {
 public:
  EmulatedArm(SimTime& time, haptics::ArmProtocol protocol, haptics::Arm arm, std::uint32_t seed);

  /// Angles of the arm's bodies at which the hand holds the arm, as a function of the true time in seconds.
  std::function<dvec3(double)> hand;
  /// Returns the angles of the stylus joints D, E and F as a function of time. If it is empty, the joints stay as in
  /// the home position.
  std::function<dvec3(double)> stylus;

  /// Creates a link to the board; several may exist.
  std::unique_ptr<haptics::Link> connect();

  /// Chooses the counter values at power-on so that encoder i of a HID board wraps when the arm passes `theta`.
  void wrap_at(int i, const dvec3& theta);

  dvec3 amperes() const { return amperes_; }
  /// Returns the force that the motors exert on the hand now.
  dvec3 force() const;
  dvec3 theta() const;

  // Errors to inject, permanently or for the next reports.
  bool unplugged = false;
  bool silent = false;  // sends no report, whatever the host writes
  int short_reports = 0, merged_reports = 0, garbage_reports = 0;
  int leaping_reports = 0;             // number of reports with a jump of all encoders
  std::array<std::int64_t, 6> slip{};  // counts lost permanently
  int error = 0;                       // text protocol: error code of the board
  bool refuses_writes = false;
  bool button = false;
  double chatter = 0;  // additional reports per second that it sends without request

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
  bool spoken_to_ = false;
  std::int64_t power_on_;                          // counter values in the home position
  std::deque<std::vector<std::uint8_t>> unasked_;  // reports that were not yet read
  double talked_ = 0;                              // number of due reports of `chatter`
};

constexpr haptics::ArmProtocol kArmProtocols[] = {haptics::ArmProtocol::kHidV1, haptics::ArmProtocol::kHidV2,
                                                  haptics::ArmProtocol::kRawHid, haptics::ArmProtocol::kText};
inline std::string name_of(haptics::ArmProtocol protocol) {
  constexpr const char* kNames[] = {"HidV1", "HidV2", "RawHid", "Text"};
  return kNames[static_cast<int>(protocol)];
}

/// An arm whose bodies weigh nothing, so that zero force is zero current.
inline haptics::Arm weightless_arm() {
  haptics::Arm arm = haptics::read_arm("assets/devices/woody_2019.json");
  arm.mass_b = arm.mass_c = 0;
  return arm;
}

}  // namespace typodont::test
