// The eyes at display time, from a tracker's samples. The render thread empties the socket each frame; packets have the
// kernel's time.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "engine/base/clock.h"
#include "engine/display/display_rig.h"

namespace typodont::display {

/// "opentrack:PORT": this machine; "opentrack:ADDRESS:PORT": a numeric IPv4 address ("0.0.0.0": all).
struct TrackerAddress {
  std::array<std::uint8_t, 4> host{127, 0, 0, 1};
  std::uint16_t port = 4242;
};
/// Empty: invalid.
std::optional<TrackerAddress> parse_tracker_address(std::string_view text);

/// From the rest pose, SI: x right, y up, z backwards; yaw, pitch, roll in this order.
struct HeadMotion {
  dvec3 translation{0};                 // m, displacement from the rest pose
  double yaw = 0, pitch = 0, roll = 0;  // rad, rotations from the rest pose
};
/// 48 bytes: six little-endian doubles, cm and degrees. Empty beyond 2 m or 360°, or not finite.
std::optional<HeadMotion> parse_opentrack(std::span<const std::byte> packet);

/// Constant-velocity Kalman filter: noise `sigma`, acceleration density `agility`² (Bar-Shalom, Li & Kirubarajan 2001,
/// section 6.2.2). Uneven and missing samples are no special case.
class MotionFilter {
 public:
  MotionFilter(double sigma, double agility) : sigma2_(sigma * sigma), density_(agility * agility) {}
  /// Ignored unless newer.
  void add(Nanos t, const dvec3& measured) noexcept;
  /// Extrapolated up to kHorizon, then constant; zero before the first.
  dvec3 at(Nanos t) const noexcept;

  // ns; farther, a constant is more accurate
  static constexpr Nanos kHorizon = 80'000'000;
  // ns without samples: restarts
  static constexpr Nanos kLost = 500'000'000;

 private:
  double sigma2_, density_;
  Nanos t_ = 0;
  bool started_ = false;
  dvec3 x_{0}, v_{0};
  double p_xx_ = 0, p_xv_ = 0, p_vv_ = 0;
};

/// Render thread.
class HeadTracker {
 public:
  struct Stats {
    std::uint64_t samples = 0;
    std::uint64_t dropped = 0;  // number of packets with invalid content
  };

  /// At `rig.head.tracker`; rest pose: the rig's eye centre and right. Throws Error.
  explicit HeadTracker(const DisplayRig& rig);
  ~HeadTracker();
  HeadTracker(const HeadTracker&) = delete;
  HeadTracker& operator=(const HeadTracker&) = delete;

  /// Reads all packets that have arrived. Never waits.
  void poll() noexcept;
  /// Normally at display time; rest pose before the first sample.
  Head at(Nanos t) const noexcept;
  Stats stats() const { return stats_; }

 private:
  Head rest_;
  glm::dmat3 R_WK_;  // rotation from the tracker's axes to frame W
  // DisplayRig::scale, of the measured motion
  double scale_;
  MotionFilter center_, right_;
  Stats stats_;
  int socket_ = -1;
};

}  // namespace typodont::display
