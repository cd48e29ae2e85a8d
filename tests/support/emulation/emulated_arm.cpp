#include "tests/support/emulation/emulated_arm.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstring>

#include "engine/base/units.h"

namespace typodont::test {

using haptics::ArmProtocol;

class EmulatedArm::Wire : public haptics::Link {
 public:
  explicit Wire(EmulatedArm& arm) : arm_(arm) {}
  int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept override { return arm_.read(buffer, timeout); }
  bool write(std::span<const std::uint8_t> bytes) noexcept override { return arm_.write(bytes); }
  Nanos now() noexcept override { return arm_.time_.now(); }

 private:
  EmulatedArm& arm_;
};

EmulatedArm::EmulatedArm(SimTime& time, ArmProtocol protocol, haptics::Arm arm, std::uint32_t seed)
    : time_(time), protocol_(protocol), arm_(std::move(arm)), random_(seed) {
  power_on_ = std::uniform_int_distribution<std::int64_t>(-32768, 32767)(random_);
  time_.on_step([this] {
    if (unplugged) amperes_ = dvec3(0);
    talk();
  });
}

std::unique_ptr<haptics::Link> EmulatedArm::connect() {
  return std::make_unique<Wire>(*this);
}

dvec3 EmulatedArm::theta() const {
  return hand(to_seconds(time_.true_now()));
}

dvec3 EmulatedArm::force() const {
  dvec3 tau;
  for (int i = 0; i < 3; ++i) {
    tau[i] = arm_.sign[static_cast<std::size_t>(i)] * amperes_[i] * arm_.torque_constant[i] / arm_.ratio(i);
  }
  return glm::inverse(glm::transpose(haptics::jacobian(arm_, theta()))) * tau;
}

std::int64_t EmulatedArm::counts_at(int i, const dvec3& theta) const {
  const auto k = static_cast<std::size_t>(i);
  return std::llround(arm_.sign[k] * theta[i] / arm_.ratio(i) * arm_.counts[k] / (2 * kPi)) - arm_.home[k];
}

void EmulatedArm::wrap_at(int i, const dvec3& theta) {
  power_on_ = 32767 - counts_at(i, theta);
}

std::vector<std::uint8_t> EmulatedArm::report() {
  const dvec3 angles = theta();
  std::array<std::int64_t, 6> counts{};
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    counts[k] = counts_at(i, angles) + power_on_ + slip[k];
    if (leaping_reports > 0) counts[k] += std::uniform_int_distribution<std::int64_t>(1500, 30'000)(random_);
  }
  leaping_reports = std::max(0, leaping_reports - 1);
  if (stylus && arm_.has_stylus()) {
    const dvec3 turned = stylus(to_seconds(time_.true_now()));
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(3 + i);
      counts[k] = std::llround(arm_.sign[k] * turned[i] * arm_.counts[k] / (2 * kPi)) - arm_.home[k];
    }
  }
  if (protocol_ == ArmProtocol::kText) {
    const std::string line = fmt::format("[{},{},{}]\n", arm_.has_stylus() ? 1 : 3, fmt::join(counts, ","), error);
    return {line.begin(), line.end()};
  }
  const std::size_t size = protocol_ == ArmProtocol::kHidV1 ? 8 : protocol_ == ArmProtocol::kHidV2 ? 14 : 64;
  std::vector<std::uint8_t> bytes(size, 0);
  for (std::size_t i = 0; i < (size == 8 ? 3u : 6u); ++i) {
    const auto raw = static_cast<std::uint16_t>(counts[i] & 0xffff);
    bytes[2 * i] = static_cast<std::uint8_t>(raw & 0xff);
    bytes[2 * i + 1] = static_cast<std::uint8_t>(raw >> 8);
  }
  if (size > 8) bytes[12] = button ? 1 : 0;
  return bytes;
}

/// A report with the requested errors.
std::vector<std::uint8_t> EmulatedArm::broken_report() {
  std::vector<std::uint8_t> bytes = report();
  if (merged_reports > 0) {
    --merged_reports;
    bytes.insert(bytes.end(), bytes.begin(), bytes.end());
  }
  if (short_reports > 0) {
    --short_reports;
    bytes.resize(std::uniform_int_distribution<std::size_t>(1, bytes.size() - 1)(random_));
  }
  if (garbage_reports > 0) {
    --garbage_reports;
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random_());
    if (protocol_ == ArmProtocol::kText) bytes.push_back('\n');
  }
  return bytes;
}

/// Sends the due reports of `chatter`. The computer queues as many as hidraw does.
void EmulatedArm::talk() {
  constexpr std::size_t kKept = 64;
  if (unplugged || silent) return;
  for (talked_ += chatter * to_seconds(SimTime::kStep); talked_ >= 1; --talked_) {
    unasked_.push_back(broken_report());
    if (unasked_.size() > kKept) unasked_.pop_front();
  }
}

int EmulatedArm::read(std::span<std::uint8_t> buffer, Nanos timeout) {
  const Nanos end = time_.true_now() + timeout;
  for (;;) {
    if (unplugged) return -1;
    if (!unasked_.empty()) {
      const std::vector<std::uint8_t>& bytes = unasked_.front();
      const std::size_t n = std::min(bytes.size(), buffer.size());
      std::memcpy(buffer.data(), bytes.data(), n);
      unasked_.pop_front();
      return static_cast<int>(n);
    }
    if (chatter > 0 && time_.true_now() < end) {
      time_.advance(std::min(SimTime::kStep, end - time_.true_now()));
      continue;
    }
    const Nanos next = (time_.true_now() / 1'000'000 + 1) * 1'000'000;  // reports leave at whole milliseconds
    if (timeout == 0 || !spoken_to_ || silent || next > end) {
      time_.advance(std::max<Nanos>(end - time_.true_now(), 0));
      return unplugged ? -1 : 0;
    }
    time_.advance(next - time_.true_now());
    if (unplugged || silent) continue;
    spoken_to_ = false;
    const std::vector<std::uint8_t> bytes = broken_report();
    const std::size_t n = std::min(bytes.size(), buffer.size());
    std::memcpy(buffer.data(), bytes.data(), n);
    return static_cast<int>(n);
  }
}

bool EmulatedArm::write(std::span<const std::uint8_t> bytes) {
  if (unplugged || refuses_writes) return false;
  if (protocol_ == ArmProtocol::kText) {
    const std::string line(bytes.begin(), bytes.end());
    int ma[3];
    if (std::sscanf(line.c_str(), "[%d,%d,%d]\n", &ma[0], &ma[1], &ma[2]) != 3) return true;
    for (int i = 0; i < 3; ++i) amperes_[i] = ma[i] * 1e-3;
  } else {
    const std::size_t size = protocol_ == ArmProtocol::kHidV1 ? 9 : protocol_ == ArmProtocol::kHidV2 ? 15 : 65;
    if (bytes.size() != size) return true;  // the board ignores unknown commands
    for (std::size_t i = 0; i < 3; ++i) {
      amperes_[static_cast<int>(i)] =
          1e-3 * static_cast<std::int16_t>(static_cast<std::uint16_t>(bytes[1 + 2 * i] | bytes[2 + 2 * i] << 8));
    }
  }
  spoken_to_ = true;
  return true;
}

}  // namespace typodont::test
