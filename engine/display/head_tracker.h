// Where the user's eyes are now and will be when the picture is shown: samples from a head tracker, filtered and
// predicted. No thread of its own: the render thread empties the socket once a frame, and each packet carries the
// kernel's time of arrival. Without a tracker in the rig nothing of this is created.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "engine/base/clock.h"
#include "engine/display/display_rig.h"

namespace typodont::display {

/// Where a tracker's packets arrive: "opentrack:PORT" listens on this machine only, "opentrack:ADDRESS:PORT" on the
/// numeric IPv4 address given ("0.0.0.0": from anywhere).
struct TrackerAddress {
  std::array<std::uint8_t, 4> host{127, 0, 0, 1};
  std::uint16_t port = 4242;
};
/// Nothing when the text is no such address.
std::optional<TrackerAddress> parse_tracker_address(std::string_view text);

/// The head relative to how it rests: as OpenTrack sends it, in SI. Axes: x to the user's right, y up, z backwards,
/// away from the picture; turns about y (yaw), x (pitch), z (roll), right-handed, applied in this order.
struct HeadMotion {
  dvec3 translation{0};                 // m
  double yaw = 0, pitch = 0, roll = 0;  // rad
};
/// 48 bytes: six little-endian doubles, cm and degrees. Nothing unless every number is finite and a head can be there
/// (2 m, 360 degrees).
std::optional<HeadMotion> parse_opentrack(std::span<const std::byte> packet);

/// Constant-velocity Kalman filter of a vector of which each component has the same noise: white noise of `sigma` in
/// what is measured, white acceleration of spectral density `agility`² in what moves (Bar-Shalom, Li & Kirubarajan
/// 2001, section 6.2.2). Its covariance knows how old the last sample is, so uneven and missing samples are no special
/// case.
class MotionFilter {
 public:
  MotionFilter(double sigma, double agility) : sigma2_(sigma * sigma), density_(agility * agility) {}
  /// A sample that is not newer than the last one is passed over.
  void add(Nanos t, const dvec3& measured) noexcept;
  /// At most kHorizon beyond the newest sample; later, the value stays there. Zero before the first sample.
  dvec3 at(Nanos t) const noexcept;

  static constexpr Nanos kHorizon = 80'000'000;  // ns; farther ahead a guess is worse than standing still
  static constexpr Nanos kLost = 500'000'000;    // ns without a sample: the next one starts afresh

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
    std::uint64_t dropped = 0;  // packets that were no head's
  };

  /// Opens the socket that `rig.head.tracker` names. The rest position is the rig's eye centre and its right; backwards
  /// is away from the picture. Throws Error where the port is taken or the address is not this machine's.
  explicit HeadTracker(const DisplayRig& rig);
  ~HeadTracker();
  HeadTracker(const HeadTracker&) = delete;
  HeadTracker& operator=(const HeadTracker&) = delete;

  /// Takes all that has arrived. Never waits.
  void poll() noexcept;
  /// The head at a time, normally that of display. As it rests until the first sample.
  Head at(Nanos t) const noexcept;
  Stats stats() const { return stats_; }

 private:
  Head rest_;
  glm::dmat3 R_WK_;  // the tracker's axes in W
  double scale_;     // of the rig's lengths
  MotionFilter center_, right_;
  Stats stats_;
  int socket_ = -1;
};

}  // namespace typodont::display
