// Tests head tracking: packets, filter, socket.
#include "engine/display/head_tracker.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::display {
namespace {

std::vector<std::byte> packet(std::array<double, 6> numbers) {
  std::vector<std::byte> bytes;
  for (const double number : numbers)
    for (int b = 0; b < 8; ++b)
      bytes.push_back(static_cast<std::byte>(std::bit_cast<std::uint64_t>(number) >> (8 * b)));
  return bytes;
}

/// A socket that sends packets to a port of this machine.
class Sender {
 public:
  explicit Sender(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    to_.sin_family = AF_INET;
    to_.sin_port = htons(port);
    to_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  }
  ~Sender() { ::close(socket_); }
  void send(const std::vector<std::byte>& bytes) {
    ASSERT_EQ(::sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_),
              static_cast<ssize_t>(bytes.size()));
  }

 private:
  int socket_;
  sockaddr_in to_{};
};

/// Starts a tracker on the first free port. Sets `port` to this port.
std::unique_ptr<HeadTracker> listen(DisplayRig rig, std::uint16_t& port) {
  for (port = 24200; port < 24300; ++port) {
    rig.head.tracker = "opentrack:" + std::to_string(port);
    try {
      return std::make_unique<HeadTracker>(rig);
    } catch (const Error&) {  // taken
    }
  }
  return nullptr;
}

TEST(TrackerAddress, ListensOnThisComputerOnlyByDefault) {
  const auto here = parse_tracker_address("opentrack:4242");
  ASSERT_TRUE(here);
  EXPECT_EQ(here->host, (std::array<std::uint8_t, 4>{127, 0, 0, 1}));
  EXPECT_EQ(here->port, 4242);
  const auto anywhere = parse_tracker_address("opentrack:0.0.0.0:5000");
  ASSERT_TRUE(anywhere);
  EXPECT_EQ(anywhere->host, (std::array<std::uint8_t, 4>{0, 0, 0, 0}));
  EXPECT_EQ(anywhere->port, 5000);
}

TEST(TrackerAddress, RefusesInvalidAddresses) {
  for (const char* text :
       {"", "opentrack", "opentrack:", "opentrack:0", "opentrack:65536", "opentrack:-1", "opentrack:42x", "freed:4242",
        "opentrack:1.2.3:4242", "opentrack:1.2.3.4.5:4242", "opentrack:1.2.3.256:4242", "opentrack:host:4242",
        "opentrack:1..2.3:4242", "opentrack:1.2.3.4:", "opentrack: 4242"})
    EXPECT_FALSE(parse_tracker_address(text)) << text;
}

TEST(OpenTrackPacket, IsSixLittleEndianDoublesInCentimetresAndDegrees) {
  const auto motion = parse_opentrack(packet({1, -2, 3.5, 90, -45, 10}));
  ASSERT_TRUE(motion);
  EXPECT_NEAR(glm::distance(motion->translation, dvec3(0.01, -0.02, 0.035)), 0, 1e-15);
  EXPECT_NEAR(motion->yaw, kPi / 2, 1e-15);
  EXPECT_NEAR(motion->pitch, -kPi / 4, 1e-15);
  EXPECT_NEAR(motion->roll, kPi / 18, 1e-15);
}

TEST(OpenTrackPacket, OfAnyOtherSizeOrImpossibleNumberIsRefused) {
  const auto good = packet({0, 0, 0, 0, 0, 0});
  for (std::size_t size = 0; size < 100; ++size) {
    std::vector<std::byte> bytes = good;
    bytes.resize(size);
    EXPECT_EQ(parse_opentrack(bytes).has_value(), size == 48) << size;
  }
  for (std::size_t i = 0; i < 6; ++i)
    for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e300, -400.0}) {
      std::array<double, 6> numbers{};
      numbers[i] = bad;
      EXPECT_FALSE(parse_opentrack(packet(numbers))) << i << " " << bad;
    }
  std::mt19937_64 random(7);
  for (int n = 0; n < 10000; ++n) {
    std::vector<std::byte> bytes(48);
    for (std::byte& b : bytes) b = static_cast<std::byte>(random());
    if (const auto motion = parse_opentrack(bytes)) {
      EXPECT_TRUE(is_finite(motion->translation));
      EXPECT_LE(glm::length(motion->translation), 4);
    }
  }
}

TEST(MotionFilter, PredictsAConstantVelocityExactlyOnceItHasSettled) {
  MotionFilter filter(0.5e-3, 0.15);
  const dvec3 start(0.1, 0.2, 0.3), velocity(0.05, -0.1, 0.02);
  Nanos t = 1;
  for (int i = 0; i < 400; ++i, t += 8'000'000) filter.add(t, start + velocity * to_seconds(t));
  const Nanos later = t + 30'000'000;
  EXPECT_LT(glm::distance(filter.at(later), start + velocity * to_seconds(later)), 1e-6);
}

TEST(MotionFilter, RemovesAThirdOfTheNoiseOfAHeadAtRestWithoutBias) {
  MotionFilter filter(0.5e-3, 0.15);
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0, 0.5e-3);
  double sum2 = 0;
  dvec3 sum(0);
  int n = 0;
  for (int i = 0; i < 5000; ++i) {
    filter.add(1 + i * Nanos{4'000'000}, dvec3(noise(random), noise(random), noise(random)));
    if (i < 500) continue;
    const dvec3 shown = filter.at(1 + i * Nanos{4'000'000});
    sum2 += glm::dot(shown, shown) / 3;
    sum += shown;
    ++n;
  }
  EXPECT_LT(std::sqrt(sum2 / n), 0.33e-3);
  EXPECT_LT(glm::length(sum / static_cast<double>(n)), 0.05e-3);
}

TEST(MotionFilter, PredictsAMovingHeadWithAQuarterOfTheErrorOfTheNewestSample) {
  MotionFilter filter(0.5e-3, 0.15);
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, 0.2e-3);
  const auto head = [](Nanos t) { return dvec3(0.05 * std::sin(2 * kPi * 0.6 * to_seconds(t)), 0, 0); };
  constexpr Nanos kAhead = 40'000'000;
  double predicted = 0, held = 0;
  dvec3 newest(0);
  for (int i = 0; i < 2500; ++i) {
    const Nanos t = 1 + i * Nanos{8'000'000};
    newest = head(t) + dvec3(noise(random), noise(random), noise(random));
    filter.add(t, newest);
    if (i < 100) continue;
    predicted += std::pow(glm::distance(filter.at(t + kAhead), head(t + kAhead)), 2);
    held += std::pow(glm::distance(newest, head(t + kAhead)), 2);
  }
  EXPECT_LT(std::sqrt(predicted), std::sqrt(held) / 4);
}

TEST(MotionFilter, StandsStillWhenSamplesStopAndStartsAfreshWhenTheyReturn) {
  MotionFilter filter(0.5e-3, 0.15);
  for (int i = 0; i < 200; ++i) filter.add(1 + i * Nanos{8'000'000}, dvec3(1e-3 * i, 0, 0));
  const Nanos last = 1 + 199 * Nanos{8'000'000};
  const dvec3 held = filter.at(last + MotionFilter::kHorizon);
  EXPECT_EQ(filter.at(last + kNanosPerSecond), held);
  EXPECT_LT(held.x, 0.199 + 0.125 * 0.08 + 1e-3);
  filter.add(last + kNanosPerSecond, dvec3(0, 0.3, 0));
  EXPECT_EQ(filter.at(last + kNanosPerSecond), dvec3(0, 0.3, 0));
  filter.add(last, dvec3(9));  // older than the newest: passed over
  EXPECT_EQ(filter.at(last + kNanosPerSecond), dvec3(0, 0.3, 0));
}

TEST(HeadTracker, MovesAndTurnsTheEyesAsThePacketsSayAndLeavesThemAtRestBefore) {
  DisplayRig rig;
  rig.head.eye_center = dvec3(0, 0, 0.6);
  std::uint16_t port = 0;
  const auto tracker = listen(rig, port);
  ASSERT_TRUE(tracker);
  EXPECT_EQ(tracker->at(now()).eye_center, rig.head.eye_center);
  Sender sender(port);
  for (int i = 0; i < 3; ++i) {
    sender.send(packet({3, -2, 5, 30, 0, 0}));
    tracker->poll();
  }
  const Head head = tracker->at(now());
  EXPECT_LT(glm::distance(head.eye_center, dvec3(0.03, -0.02, 0.65)), 1e-6);
  // The head has turned to the left, so the right eye is nearer to the picture.
  EXPECT_LT(glm::distance(head.right, dvec3(std::cos(kPi / 6), 0, -std::sin(kPi / 6))), 1e-6);
  EXPECT_EQ(head.ipd, rig.head.ipd);
}

TEST(HeadTracker, EyesBehindThePictureAreRejected) {
  for (const bool mirrored : {false, true}) {
    DisplayRig rig;
    if (mirrored) rig.mirror = Mirror{dvec3(0, 0, 1), 0.05, 0, 1.52};
    Head head = rig.head;
    const double sign = mirrored ? -1 : 1;  // seen from the other side, at 0.1 m − z
    const double picture = mirrored ? 0.1 : 0.0;
    for (const double distance : {0.051, 0.3, 2.0}) {
      head.eye_center.z = picture + sign * distance;
      EXPECT_TRUE(sees(rig, head)) << distance << mirrored;
    }
    for (const double distance : {0.049, 0.0, -0.3}) {
      head.eye_center.z = picture + sign * distance;
      EXPECT_FALSE(sees(rig, head)) << distance << mirrored;
    }
    head.eye_center.z = std::nan("");
    EXPECT_FALSE(sees(rig, head));
  }
}

TEST(HeadTracker, APortInUseIsReported) {
  DisplayRig rig;
  std::uint16_t port = 0;
  const auto first = listen(rig, port);
  ASSERT_TRUE(first);
  rig.head.tracker = "opentrack:" + std::to_string(port);
  EXPECT_THROW(HeadTracker second(rig), Error);
}

}  // namespace
}  // namespace typodont::display
