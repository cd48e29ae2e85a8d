#include "engine/display/head_tracker.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <ctime>

#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::display {

namespace {

constexpr std::string_view kOpenTrack = "opentrack:";
constexpr std::size_t kPacketBytes = 48;

// Noise that remains after OpenTrack's filter, and the motion of a working user's head (root of the spectral density).
constexpr double kPositionSigma = 0.5e-3;  // m, standard deviation of the noise of a tracked position
constexpr double kPositionAgility = 0.15;  // m/s^1.5, root of the spectral density of the head's acceleration
constexpr double kDirectionSigma = 5e-3;   // rad, standard deviation of the noise of a tracked direction
constexpr double kDirectionAgility = 1;    // rad/s^1.5, square root of the spectral density of angular acceleration

template <class Number>
std::optional<Number> whole_number(std::string_view text, Number highest) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value > highest) return std::nullopt;
  return static_cast<Number>(value);
}

dvec3 toward_user(const DisplayRig& rig) {
  const Screen screen = rig.mirror ? reflect(*rig.mirror, rig.screen) : rig.screen;
  const dvec3 middle = (screen.lower_right + screen.upper_left) / 2.0;
  return glm::normalize(rig.head.eye_center - middle);
}

/// Age of a packet by the kernel's time, ns. An impossible age counts as 0, because someone may have set the clock.
Nanos age_of(const msghdr& message) noexcept {
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c; c = CMSG_NXTHDR(const_cast<msghdr*>(&message), c)) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec stamp{}, wall{};
    std::memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
    clock_gettime(CLOCK_REALTIME, &wall);
    const Nanos age = (wall.tv_sec - stamp.tv_sec) * kNanosPerSecond + (wall.tv_nsec - stamp.tv_nsec);
    return age >= 0 && age < kNanosPerSecond ? age : 0;
  }
  return 0;
}

}  // namespace

std::optional<TrackerAddress> parse_tracker_address(std::string_view text) {
  if (!text.starts_with(kOpenTrack)) return std::nullopt;
  text.remove_prefix(kOpenTrack.size());
  TrackerAddress address;
  if (const std::size_t colon = text.find(':'); colon != std::string_view::npos) {
    std::string_view host = text.substr(0, colon);
    text.remove_prefix(colon + 1);
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t dot = host.find('.');
      if ((dot == std::string_view::npos) != (i == 3)) return std::nullopt;
      const auto part = whole_number<std::uint8_t>(host.substr(0, dot), 255);
      if (!part) return std::nullopt;
      address.host[i] = *part;
      host.remove_prefix(i == 3 ? host.size() : dot + 1);
    }
  }
  const auto port = whole_number<std::uint16_t>(text, 65535);
  if (!port || *port == 0) return std::nullopt;
  address.port = *port;
  return address;
}

std::optional<HeadMotion> parse_opentrack(std::span<const std::byte> packet) {
  if (packet.size() != kPacketBytes) return std::nullopt;
  std::array<double, 6> numbers;
  for (std::size_t i = 0; i < 6; ++i) {
    std::uint64_t bits = 0;
    for (std::size_t b = 0; b < 8; ++b) bits |= std::to_integer<std::uint64_t>(packet[8 * i + b]) << (8 * b);
    numbers[i] = std::bit_cast<double>(bits);
    const double most = i < 3 ? 200 : 360;
    // Written with `!` and <=, so that NaN is refused, too.
    if (!(std::abs(numbers[i]) <= most)) return std::nullopt;
  }
  return HeadMotion{dvec3(numbers[0], numbers[1], numbers[2]) * 1e-2, numbers[3] * kDegree, numbers[4] * kDegree,
                    numbers[5] * kDegree};
}

void MotionFilter::add(Nanos t, const dvec3& measured) noexcept {
  if (started_ && t <= t_) return;
  if (!started_ || t - t_ > kLost) {
    started_ = true;
    t_ = t;
    x_ = measured;
    v_ = dvec3(0);
    p_xx_ = sigma2_;
    p_xv_ = 0;
    p_vv_ = 1;  // (m/s)², initial variance of the head's speed
    return;
  }
  const double dt = to_seconds(t - t_);
  t_ = t;
  // Predicts the state at the measurement's time (Kalman filter).
  x_ += v_ * dt;
  p_xx_ += dt * (2 * p_xv_ + dt * p_vv_) + density_ * dt * dt * dt / 3;
  p_xv_ += dt * p_vv_ + density_ * dt * dt / 2;
  p_vv_ += density_ * dt;
  // Corrects the state by the measurement (Kalman filter).
  const double s = p_xx_ + sigma2_, k_x = p_xx_ / s, k_v = p_xv_ / s;
  const dvec3 innovation = measured - x_;
  x_ += k_x * innovation;
  v_ += k_v * innovation;
  p_vv_ -= k_v * p_xv_;
  p_xv_ *= 1 - k_x;
  p_xx_ *= 1 - k_x;
}

dvec3 MotionFilter::at(Nanos t) const noexcept {
  const Nanos ahead = std::clamp<Nanos>(t - t_, -kHorizon, kHorizon);
  return started_ ? x_ + v_ * to_seconds(ahead) : dvec3(0);
}

HeadTracker::HeadTracker(const DisplayRig& rig)
    : rest_(rig.head),
      scale_(rig.scale),
      center_(kPositionSigma, kPositionAgility),
      right_(kDirectionSigma, kDirectionAgility) {
  const dvec3 right = glm::normalize(rest_.right);
  const dvec3 up = glm::normalize(glm::cross(toward_user(rig), right));
  R_WK_ = glm::dmat3(right, up, glm::cross(right, up));

  const auto address = parse_tracker_address(rest_.tracker);
  if (!address) throw Error("the rig's head.tracker", "", rest_.tracker, "opentrack:PORT or opentrack:ADDRESS:PORT");
  socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket_ < 0) throw Error("head tracker", "", std::strerror(errno), "a UDP socket");
  const int on = 1;
  (void)::setsockopt(socket_, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(address->port);
  std::memcpy(&name.sin_addr, address->host.data(), 4);
  if (::bind(socket_, reinterpret_cast<const sockaddr*>(&name), sizeof name) != 0) {
    const std::string why = std::strerror(errno);
    ::close(socket_);
    throw Error("head tracker", rest_.tracker, why, "a free UDP port of this machine");
  }
}

HeadTracker::~HeadTracker() {
  ::close(socket_);
}

void HeadTracker::poll() noexcept {
  // The buffer is one byte longer than a packet, to recognise longer ones. At most 500 packets per frame (two seconds
  // of the fastest tracker), so that they cannot delay a picture.
  for (int most = 500; most > 0; --most) {
    std::array<std::byte, kPacketBytes + 1> bytes;
    alignas(cmsghdr) std::array<char, 128> control;
    iovec io{bytes.data(), bytes.size()};
    msghdr message{};
    message.msg_iov = &io;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t size = ::recvmsg(socket_, &message, MSG_DONTWAIT);
    if (size < 0) return;
    const auto motion = parse_opentrack({bytes.data(), static_cast<std::size_t>(size)});
    if (!motion) {
      ++stats_.dropped;
      continue;
    }
    ++stats_.samples;
    const Nanos t = now() - age_of(message);
    const dquat R_KH = glm::angleAxis(motion->yaw, dvec3(0, 1, 0)) * glm::angleAxis(motion->pitch, dvec3(1, 0, 0)) *
                       glm::angleAxis(motion->roll, dvec3(0, 0, 1));
    center_.add(t, R_WK_ * motion->translation);
    right_.add(t, R_WK_ * (R_KH * dvec3(1, 0, 0)));
  }
}

Head HeadTracker::at(Nanos t) const noexcept {
  Head head = rest_;
  if (stats_.samples == 0) return head;
  head.eye_center = rest_.eye_center + scale_ * center_.at(t);
  const dvec3 right = right_.at(t);
  const double length = glm::length(right);
  if (length > 0.5) head.right = right / length;
  return head;
}

}  // namespace typodont::display
