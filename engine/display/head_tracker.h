// Present and predicted positions of the user's eyes: filters the samples of a head tracker and predicts them for the
// time of display. There is no extra thread: the render thread empties the socket once per frame, and each packet has
// the kernel's time of arrival. Without a tracker in the rig, no HeadTracker is created.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "engine/base/clock.h"
#include "engine/display/display_rig.h"

namespace typodont::display {

/// Address at which a tracker's packets arrive. "opentrack:PORT" listens on this machine only;
/// "opentrack:ADDRESS:PORT" listens on the given numeric IPv4 address ("0.0.0.0": on all addresses of this machine).
struct TrackerAddress {
  std::array<std::uint8_t, 4> host{127, 0, 0, 1};
  std::uint16_t port = 4242;
};
/// Parses the address of a tracker. Returns no value if the text is not a valid address.
std::optional<TrackerAddress> parse_tracker_address(std::string_view text);

/// Motion of the head relative to its rest pose, as OpenTrack sends it, in SI units. Axes: x to the user's right, y up,
/// z backwards, away from the picture. Rotations about y (yaw), x (pitch), z (roll), right-handed, applied in this
/// order.
struct HeadMotion {
  dvec3 translation{0};                 // m, displacement from the rest pose
  double yaw = 0, pitch = 0, roll = 0;  // rad, rotations from the rest pose
};
/// Parses a packet of 48 bytes: six little-endian doubles, in cm and degrees. No value if a number is not finite or not
/// plausible for a head (limits: 2 m, 360 degrees).
std::optional<HeadMotion> parse_opentrack(std::span<const std::byte> packet);

/// Constant-velocity Kalman filter for a vector whose components have equal noise: white measurement noise of standard
/// deviation `sigma`, and white acceleration of spectral density `agility`² (Bar-Shalom, Li & Kirubarajan 2001, section
/// 6.2.2). Uneven and missing samples need no special case, because the covariance depends on the age of the last
/// sample.
class MotionFilter {
 public:
  MotionFilter(double sigma, double agility) : sigma2_(sigma * sigma), density_(agility * agility) {}
  /// Adds a sample. Ignores it if it is not newer than the last one.
  void add(Nanos t, const dvec3& measured) noexcept;
  /// Returns the value at time t. It is extrapolated at most kHorizon beyond the newest sample, and constant after this
  /// time. Before the first sample it is zero.
  dvec3 at(Nanos t) const noexcept;

  // ns; a value is extrapolated for at most this time beyond the newest sample. After this time the value stays
  // constant, because a longer extrapolation would be less accurate than a constant value.
  static constexpr Nanos kHorizon = 80'000'000;
  // ns, if no sample arrives for a longer time than this, the filter restarts
  static constexpr Nanos kLost = 500'000'000;

 private:
  double sigma2_, density_;
  Nanos t_ = 0;
  bool started_ = false;
  dvec3 x_{0}, v_{0};
  double p_xx_ = 0, p_xv_ = 0, p_vv_ = 0;
};

/// Receives the head's motion and predicts the position of the eyes. Render thread only.
class HeadTracker {
 public:
  struct Stats {
    std::uint64_t samples = 0;
    std::uint64_t dropped = 0;  // number of packets with invalid content
  };

  /// Opens the socket at the address `rig.head.tracker`. The rest pose is given by the rig's eye centre and right
  /// vector; the backwards axis points away from the picture. Throws Error if the port is in use or the address does
  /// not belong to this machine.
  explicit HeadTracker(const DisplayRig& rig);
  ~HeadTracker();
  HeadTracker(const HeadTracker&) = delete;
  HeadTracker& operator=(const HeadTracker&) = delete;

  /// Reads all packets that have arrived. Never waits.
  void poll() noexcept;
  /// Returns the head at time t, normally the time of display. Before the first sample, this is the rest pose.
  Head at(Nanos t) const noexcept;
  Stats stats() const { return stats_; }

 private:
  Head rest_;
  glm::dmat3 R_WK_;  // rotation from the tracker's axes to frame W
  // Factor by which the measured motion of the head is multiplied (DisplayRig::scale): ratio of the lengths in the rig
  // to the real lengths. It is less than 1 if the rig's picture is magnified.
  double scale_;
  MotionFilter center_, right_;
  Stats stats_;
  int socket_ = -1;
};

}  // namespace typodont::display
