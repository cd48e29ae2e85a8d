#include "haptics/devices/woodenhaptics.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "engine/base/error.h"
#include "engine/contract/contact.h"
#include "haptics/devices.h"
#include "haptics/devices/encoder.h"
#include "haptics/devices/fd_link.h"
#include "haptics/devices/hid.h"
#include "haptics/devices/watchdog_process.h"

namespace typodont::haptics {

namespace {

// ns without a report after which zero currents are sent, because the board sends a report only after a command.
constexpr Nanos kWake = 10'000'000;
constexpr Nanos kRestOfLine = 2'000'000;  // ns, longest waiting time for the rest of an incomplete line
constexpr Nanos kLost = 100'000'000;      // ns without a valid report, after which the arm counts as lost
constexpr double kGravityRamp = 0.5;      // s, time constant with which gravity compensation starts

class ArmDevice : public HapticDevice {
 public:
  ArmDevice(std::unique_ptr<Link> link, ArmProtocol protocol, Arm arm, DeviceInfo identity)
      : link_(std::move(link)),
        protocol_(protocol),
        arm_(std::move(arm)),
        info_(std::move(identity)),
        zero_(encode(protocol, dvec3(0))),
        watchdog_process_(link_->descriptor(), zero_.span()) {
    info_.force_limit = arm_.force_limit;
    info_.continuous_force = arm_.continuous_force;
    info_.max_stiffness = arm_.stiffness;
    info_.vibration_band = arm_.vibration_band;
    info_.silence = arm_.silence;
    info_.position_step = position_step(arm_);
    info_.counts_from_rest = true;
  }
  ~ArmDevice() override { release(); }

  const DeviceInfo& info() const noexcept override { return info_; }
  std::uint32_t faults() const noexcept override { return faults_; }
  std::span<const double> joints() const noexcept override {
    return {joints_.data(), homed_ ? (arm_.has_stylus() ? 6u : 3u) : 0u};
  }

  bool read(HandSample& sample) noexcept override {
    faults_ = 0;
    Nanos waited = 0;  // ns, total waiting time; a pause of this process counts as at most 2 × kWake
    bool half_a_line = false;
    for (;;) {
      const Nanos before = link_->now();
      const int n = read_newest(half_a_line ? kRestOfLine : kWake);
      const Nanos t = link_->now();
      waited += std::clamp<Nanos>(t - before, 0, 2 * kWake);
      if (n < 0 || waited > kLost) {
        faults_ |= bits(Fault::kDeviceLost);
        release();
        return false;
      }
      std::optional<ArmReport> report;
      if (n > 0) report = parse();
      if (!report) {
        // If only half a line has arrived, waits for more.
        half_a_line = protocol_ == ArmProtocol::kText && n > 0 && !rubbish_;
        if (!half_a_line) {
          release();  // sends zero force; the board answers with a report
          faults_ |= bits(Fault::kBadInput);
        }
        continue;
      }
      if (!take(*report, to_seconds(t - last_good_))) {
        release();
        faults_ |= bits(Fault::kBadInput);
        continue;
      }
      last_good_ = t;
      spacing_.taken(t);
      Counts counts;
      for (std::size_t i = 0; i < 6; ++i) counts[i] = encoders_[i].value();
      theta_ = true_angles(arm_, counts);
      const dvec3 body = body_angles(arm_, counts);
      for (int i = 0; i < 3; ++i) joints_[static_cast<std::size_t>(i)] = body[i];
      if (arm_.has_stylus()) {
        const dvec3 stylus = stylus_angles(arm_, counts);
        for (int i = 0; i < 3; ++i) joints_[static_cast<std::size_t>(3 + i)] = stylus[i];
      }
      sample = {t, stylus_pose(arm_, counts), 0};
      return true;
    }
  }

  void write(const dvec3& f_T_W, const dvec3&) noexcept override {
    gravity_share_ = std::min(1.0, gravity_share_.load() + 1 / (kGravityRamp * info_.rate));
    const Currents currents = motor_currents(arm_, theta_, f_T_W, gravity_share_.load() * gravity_torque(arm_, theta_));
    // The watchdog process must learn of a force before it is sent.
    watchdog_process_.note_write(currents.amperes != dvec3(0), now());
    link_->write(encode(protocol_, currents.amperes).span());
  }

  void release() noexcept override {
    gravity_share_ = 0;
    link_->write(zero_.span());
    watchdog_process_.note_write(false, now());
  }

 private:
  /// Waits for a report, then reads all queued reports and keeps the newest. Returns the result of Link::read().
  int read_newest(Nanos timeout) noexcept {
    const int first = hear_once(timeout);
    for (int queued = 0; first > 0;) {
      const Nanos early = std::max<Nanos>(spacing_.left(link_->now()), 0);
      if (early == 0 && ++queued > kMaxQueued) break;
      const int n = hear_once(early);
      if (n < 0 || (n == 0 && early == 0)) break;
    }
    return first;
  }
  int hear_once(Nanos timeout) noexcept {
    std::array<std::uint8_t, 256> bytes;
    const int n = link_->read(bytes, timeout);
    if (n <= 0) return n;
    heard_size_ = static_cast<std::size_t>(n);
    if (protocol_ == ArmProtocol::kText) {
      lines_.add({bytes.data(), heard_size_});
    } else {
      heard_ = bytes;
    }
    return n;
  }
  std::optional<ArmReport> parse() noexcept {
    if (protocol_ != ArmProtocol::kText) return parse_hid(protocol_, {heard_.data(), heard_size_});
    const auto line = lines_.take();
    const auto report = line ? parse_text(*line) : std::nullopt;
    rubbish_ = line && !report;
    return report;
  }

  /// Updates the encoders. Returns false if a count is impossible.
  bool take(const ArmReport& report, double dt) noexcept {
    using Step = Encoder::Step;
    // After a clock jump, accepts any motion that is possible in 0.5 s.
    if (!(dt > 0 && dt < 0.5)) dt = 0.5;
    bool rejected = false, slipped = false;
    for (int i = 0; i < (report.stylus && arm_.has_stylus() ? 6 : 3); ++i) {
      const std::size_t k = static_cast<std::size_t>(i);
      const std::int64_t reach = arm_.reach(i, dt), nearby = arm_.reach(i, 2e-3);
      const Step step = protocol_ == ArmProtocol::kText
                            ? encoders_[k].read32(report.encoders[k], reach, nearby)
                            : encoders_[k].read16(static_cast<std::int16_t>(report.encoders[k]), reach, nearby);
      rejected |= step == Step::kRejected;
      slipped |= step == Step::kSlipped;
    }
    if (rejected) return false;
    if (!homed_ || (report.button && !button_)) {
      for (std::size_t i = 0; i < 6; ++i) encoders_[i].home(arm_.home[i]);
      // Homing makes the pose jump: no force in this tick.
      if (homed_) faults_ |= bits(Fault::kBadInput);
      homed_ = true;
      slipped = false;
    }
    button_ = report.button;
    if (slipped || report.error != 0) faults_ |= bits(Fault::kBadInput);
    return true;
  }

  std::unique_ptr<Link> link_;
  ArmProtocol protocol_;
  Arm arm_;
  DeviceInfo info_;
  const ArmCommand zero_;
  WatchdogProcess watchdog_process_;
  std::array<Encoder, 6> encoders_;
  LineAssembler lines_;
  std::array<std::uint8_t, 256> heard_{};  // newest report of a board with HID
  std::size_t heard_size_ = 0;
  SampleSpacing spacing_{info_.rate};
  dvec3 theta_{0};
  std::array<double, 6> joints_{};
  Nanos last_good_ = 0;
  std::uint32_t faults_ = 0;
  bool homed_ = false, button_ = false, rubbish_ = false;
  std::atomic<double> gravity_share_{0};
};

bool is_arm(const HidNode& node) {
  if (node.vendor == 0x1234 && node.product == 0x0006) return true;
  // A Teensy with raw HID has a second interface with the same ids.
  return node.vendor == 0x16c0 && node.product == 0x0486 && node.usage_page == 0xffab && node.usage == 0x0200;
}

/// Serial ports of boards, by names that stay the same when plugged in again.
std::vector<std::filesystem::path> serial_boards() {
  std::vector<std::filesystem::path> found;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/dev/serial/by-id", none)) {
    if (entry.path().filename().string().find("Teensy") != std::string::npos) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

FoundDevice found_at(const std::string& node, std::string model, std::string serial) {
  FoundDevice device{"woodenhaptics:" + (serial.empty() ? node : serial),
                     "force feedback",
                     std::move(model),
                     std::move(serial),
                     node,
                     5,
                     true,
                     ""};
  if (::access(node.c_str(), R_OK | W_OK) != 0) {
    device.permitted = false;
    device.mend = kPermissionRemedy;
  }
  return device;
}

/// Serial number in a port's name: "1234560" of "usb-Teensyduino_USB_Serial_1234560-if00".
std::string serial_of(const std::filesystem::path& port) {
  std::string name = port.filename().string();
  name = name.substr(0, name.find("-if"));
  const std::size_t at = name.rfind('_');
  return at == std::string::npos ? "" : name.substr(at + 1);
}

std::vector<FoundDevice> find() {
  std::vector<FoundDevice> devices;
  for (const HidNode& node : enumerate_hid()) {
    if (is_arm(node))
      devices.push_back(found_at(node.path, node.name.empty() ? "WoodenHaptics" : node.name, node.serial));
  }
  for (const auto& port : serial_boards()) {
    devices.push_back(found_at(port.string(), "Teensy board (WoodenHaptics or Polhem)", serial_of(port)));
  }
  return devices;
}

std::unique_ptr<HapticDevice> open(const std::string& rest, const HandOptions& options) {
  // The address after the colon: "[PATH or SERIAL][,PRESET]".
  const std::size_t comma = rest.rfind(',');
  const std::string which = rest.substr(0, comma);
  std::string preset = comma == std::string::npos ? "" : rest.substr(comma + 1);
  std::string path = which, serial;
  if (!which.starts_with('/')) {
    const auto devices = find();
    const auto match = std::find_if(devices.begin(), devices.end(),
                                    [&](const FoundDevice& d) { return which.empty() || d.serial == which; });
    if (match == devices.end()) {
      throw Error("woodenhaptics:" + rest, "", devices.empty() ? "no such arm plugged in" : "no arm of that serial",
                  "an arm; see: typodont devices");
    }
    path = match->node;
    serial = match->serial;
  }
  const bool is_serial = path.find("/hidraw") == std::string::npos;
  std::unique_ptr<Link> link = is_serial ? open_serial(path) : open_hid(path);
  const ArmHello hello = greet_arm(*link, is_serial, path);
  if (preset.empty()) preset = hello.model == 1 ? "polhem_v3" : "woody";
  Arm arm = read_arm(options.assets / "devices" / (preset + ".json"));
  if (options.arm) use_measured(arm, *options.arm);
  DeviceInfo identity{"woodenhaptics:" + rest, arm.name, serial};
  return make_arm_device(std::move(link), hello.protocol, std::move(arm), std::move(identity));
}

}  // namespace

ArmHello greet_arm(Link& link, bool serial, const std::string& where) {
  const Nanos give_up = link.now() + kNanosPerSecond;
  std::uint8_t buffer[256];
  if (serial) {
    // The board sends a line only after a command; the first line may contain an old state.
    const ArmCommand zero = encode(ArmProtocol::kText, dvec3(0));
    LineAssembler lines;
    while (link.now() < give_up) {
      link.write(zero.span());
      const int n = link.read(buffer, kWake);
      if (n < 0) throw Error(where, "", "a port that hung up", "a WoodenHaptics or Polhem board");
      lines.add({buffer, static_cast<std::size_t>(n)});
      const auto line = lines.take();
      if (!line || line->size() <= 8) continue;
      if (const auto report = parse_text(*line)) return {ArmProtocol::kText, report->model};
    }
    throw Error(where, "", "no line of eight numbers within a second", "a WoodenHaptics or Polhem board");
  }
  std::size_t last = 0;
  for (int round = 0; link.now() < give_up; ++round) {
    const int n = link.read(buffer, kWake);
    if (n < 0) throw Error(where, "", "a device that was unplugged", "a WoodenHaptics or Polhem board");
    if (n == 0) {  // no report: the board is idle, or expects commands of another length
      static constexpr ArmProtocol kKinds[] = {ArmProtocol::kHidV1, ArmProtocol::kHidV2, ArmProtocol::kRawHid};
      link.write(encode(kKinds[round % 3], dvec3(0)).span());
      continue;
    }
    const auto protocol = protocol_of_report(static_cast<std::size_t>(n));
    if (protocol) {
      link.write(encode(*protocol, dvec3(0)).span());
      // Requires two successive reports of the same length, because one report may have a wrong length by chance.
      if (last == static_cast<std::size_t>(n)) return {*protocol, 0};
    }
    last = static_cast<std::size_t>(n);
  }
  throw Error(where, "", "no report of 8, 14 or 64 bytes within a second", "a WoodenHaptics or Polhem board");
}

std::unique_ptr<HapticDevice> make_arm_device(std::unique_ptr<Link> link, ArmProtocol protocol, Arm arm,
                                              DeviceInfo identity) {
  return std::make_unique<ArmDevice>(std::move(link), protocol, std::move(arm), std::move(identity));
}

extern const Driver woodenhaptics_driver;
const Driver woodenhaptics_driver{
    .scheme = "woodenhaptics",
    .rest = "[PATH or SERIAL][,PRESET]",
    .about = "WoodenHaptics and Polhem arms over HID or a serial port",
    .open = open,
    .find = find,
};

}  // namespace typodont::haptics
