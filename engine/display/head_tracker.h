// Predicts the eyes' positions at display time from the samples of a head tracker. The render thread empties the socket
// in each frame; packets carry the kernel's time.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "engine/base/clock.h"
#include "engine/display/display_rig.h"

namespace typodont::display {

/// Reads "opentrack:PORT" (this computer) or "opentrack:ADDRESS:PORT" (numeric IPv4 address; "0.0.0.0": all
/// interfaces).
struct TrackerAddress {
  std::array<std::uint8_t, 4> host{127, 0, 0, 1};
  std::uint16_t port = 4242;
};
/// Returns nullopt for an invalid address.
std::optional<TrackerAddress> parse_tracker_address(std::string_view text);

/// Motion of the head from its rest pose, SI units: x right, y up, z backwards; rotations in the order yaw, pitch,
/// roll.
struct HeadMotion {
  dvec3 translation{0};                 // m, displacement from the rest pose
  double yaw = 0, pitch = 0, roll = 0;  // rad, rotations from the rest pose
};
/// Reads a packet of 48 bytes: six little-endian doubles, cm and degrees. Returns nullopt for values beyond 2 m or
/// 360°, or not finite.
std::optional<HeadMotion> parse_opentrack(std::span<const std::byte> packet);

/// Kalman filter for constant velocity, with measurement noise `sigma` and spectral density `agility`² of the
/// acceleration (Bar-Shalom, Li & Kirubarajan 2001, section 6.2.2). Samples may be irregular or missing.
class MotionFilter {
 public:
  MotionFilter(double sigma, double agility) : sigma2_(sigma * sigma), density_(agility * agility) {}
  /// Adds a measurement; ignored unless it is newer than the last one.
  void add(Nanos t, const dvec3& measured) noexcept;
  /// Extrapolated value: up to kHorizon after the last sample, then constant. Zero before the first sample.
  dvec3 at(Nanos t) const noexcept;

  // Longest extrapolation, ns; after this time, a constant value is more accurate.
  static constexpr Nanos kHorizon = 80'000'000;
  // Time without samples after which the filter restarts, ns.
  static constexpr Nanos kLost = 500'000'000;

 private:
  double sigma2_, density_;
  Nanos t_ = 0;
  bool started_ = false;
  dvec3 x_{0}, v_{0};
  double p_xx_ = 0, p_xv_ = 0, p_vv_ = 0;
};

/// Tracker of the head. Render thread only.
class HeadTracker {
 public:
  struct Stats {
    std::uint64_t samples = 0;
    std::uint64_t dropped = 0;  // number of packets with invalid content
  };

  /// Opens the address `rig.head.tracker`. The rest pose is the rig's eye centre and right vector. Throws Error.
  explicit HeadTracker(const DisplayRig& rig);
  ~HeadTracker();
  HeadTracker(const HeadTracker&) = delete;
  HeadTracker& operator=(const HeadTracker&) = delete;

  /// Reads all packets that have arrived. Never waits.
  void poll() noexcept;
  /// Predicted head at time t, normally the display time; before the first sample, the rest pose.
  Head at(Nanos t) const noexcept;
  Stats stats() const { return stats_; }

 private:
  Head rest_;
  glm::dmat3 R_WK_;  // rotation from the tracker's axes to frame W
  // Factor by which the measured motion is multiplied: DisplayRig::scale.
  double scale_;
  MotionFilter center_, right_;
  Stats stats_;
  int socket_ = -1;
};

}  // namespace typodont::display
