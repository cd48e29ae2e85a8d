#include "haptics/devices/spacemouse.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/error.h"
#include "haptics/devices.h"
#include "haptics/devices/fd_link.h"
#include "haptics/devices/hid.h"

namespace typodont::haptics {

namespace {

constexpr double kFullScale = 350;  // counts at full deflection of the cap
// Without a report for this time, the cap counts as released, ns.
constexpr Nanos kSilence = 200'000'000;

constexpr std::array<std::uint16_t, 11> kLogitech{0xc603, 0xc605, 0xc606, 0xc621, 0xc623, 0xc625,
                                                  0xc626, 0xc627, 0xc628, 0xc629, 0xc62b};
constexpr std::array<std::uint16_t, 10> k3Dconnexion{0xc62e, 0xc62f, 0xc631, 0xc632, 0xc633,
                                                     0xc635, 0xc636, 0xc638, 0xc63a, 0xc652};

dvec3 axes_at(std::span<const std::uint8_t> report, std::size_t at) {
  dvec3 v;
  for (int i = 0; i < 3; ++i) {
    const std::size_t k = at + 2 * static_cast<std::size_t>(i);
    const auto raw = static_cast<std::int16_t>(static_cast<std::uint16_t>(report[k] | report[k + 1] << 8));
    v[i] = std::clamp(raw / kFullScale, -1.0, 1.0);
  }
  return v;
}

/// Response of the cap: zero within the dead zone `dead`, then a gradual rise.
dvec3 shape(const dvec3& v, double dead) {
  dvec3 out;
  for (int i = 0; i < 3; ++i) {
    const double a = std::max(0.0, (std::abs(v[i]) - dead) / (1 - dead));
    out[i] = std::copysign(0.4 * a + 0.6 * a * a * a, v[i]);
  }
  return out;
}

/// From the cap's axes (x right, y to the user, z down) to the base frame H (x right, y away, z up).
dvec3 cap_to_base(const dvec3& v) {
  return {v.x, -v.y, -v.z};
}

class SpaceMouse : public HapticDevice {
 public:
  SpaceMouse(std::unique_ptr<Link> link, const SpaceMouseControl& control, double rate, DeviceInfo identity)
      : link_(std::move(link)), control_(control), info_(std::move(identity)), period_(from_seconds(1 / rate)) {
    info_.rate = rate;
  }
  const DeviceInfo& info() const noexcept override { return info_; }
  void write(const dvec3&, const dvec3&) noexcept override {}

  bool read(HandSample& sample) noexcept override {
    if (due_ == 0) due_ = heard_ = link_->now();
    due_ += period_;
    // After a pause of the program, skips the missed samples.
    if (link_->now() - due_ > kSilence) due_ = link_->now();
    for (int late = 0; late <= kMaxQueued;) {
      std::uint8_t buffer[64];
      const Nanos left = std::max<Nanos>(due_ - link_->now(), 0);
      late += left == 0;
      const int n = link_->read(buffer, left);
      if (n < 0) return false;
      if (n > 0) {
        if (parse_spacemouse({buffer, static_cast<std::size_t>(n)}, state_)) heard_ = link_->now();
      } else if (left == 0 || link_->now() >= due_) {
        break;
      }
    }
    // Without reports the cap counts as released. Otherwise the tool would drift if the report of the release was lost.
    if (link_->now() - heard_ > kSilence) state_.push = state_.twist = dvec3(0);

    const double dt = to_seconds(period_);
    const double fraction = 1 - std::exp(-dt / control_.smoothing);
    push_ += fraction * (cap_to_base(shape(state_.push, control_.dead_zone)) - push_);
    twist_ += fraction * (cap_to_base(shape(state_.twist, control_.dead_zone)) - twist_);
    if (control_.rate_control) {
      pose_.p += control_.speed * dt * push_;
      pose_.R = glm::normalize(rotation(control_.turn_speed * dt * twist_) * pose_.R);
    } else {
      pose_ = {control_.reach * push_, rotation(control_.turn_reach * twist_)};
    }
    sample = {due_, pose_, state_.buttons & 1 ? 1.0 : 0.0};
    return true;
  }

 private:
  static dquat rotation(const dvec3& v) {
    const double angle = glm::length(v);
    return angle > 1e-12 ? glm::angleAxis(angle, v / angle) : dquat(1, 0, 0, 0);
  }

  std::unique_ptr<Link> link_;
  SpaceMouseControl control_;
  DeviceInfo info_;
  Nanos period_, due_ = 0, heard_ = 0;
  SpaceMouseState state_;
  dvec3 push_{0}, twist_{0};
  Pose pose_;
};

std::vector<FoundDevice> find() {
  std::vector<FoundDevice> devices;
  for (const HidNode& node : enumerate_hid()) {
    // A SpaceMouse has several HID interfaces; only the multi-axis controller (usage page 1, usage 8) is listed.
    if (!is_spacemouse(node.vendor, node.product)) continue;
    if (node.usage_page != 0 && !(node.usage_page == 1 && node.usage == 8)) continue;
    const bool permitted = ::access(node.path.c_str(), R_OK | W_OK) == 0;
    devices.push_back({"spacemouse:" + (node.serial.empty() ? node.path : node.serial), "6-DoF mouse",
                       node.name.empty() ? "SpaceMouse" : node.name, node.serial, node.path, 0, permitted,
                       permitted ? "" : kPermissionRemedy});
  }
  return devices;
}

std::unique_ptr<HapticDevice> open(const std::string& rest, const HandOptions& options) {
  // The address after the colon: "[PATH or SERIAL][,position]".
  SpaceMouseControl control;
  std::string which = rest;
  if (const std::size_t comma = rest.rfind(','); comma != std::string::npos) {
    const std::string mode = rest.substr(comma + 1);
    if (mode != "rate" && mode != "position") throw Error("spacemouse:" + rest, "", mode, "rate or position");
    control.rate_control = mode == "rate";
    which = rest.substr(0, comma);
  }
  for (const FoundDevice& device : find()) {
    if (!which.empty() && which != device.node && which != device.serial) continue;
    return make_spacemouse(open_hid(device.node), control, options.rate,
                           {"spacemouse:" + rest, device.model, device.serial});
  }
  throw Error("spacemouse:" + rest, "", "no such SpaceMouse plugged in", "one; see: typodont devices");
}

}  // namespace

bool is_spacemouse(std::uint16_t vendor, std::uint16_t product) {
  const auto in = [&](const auto& list) { return std::find(list.begin(), list.end(), product) != list.end(); };
  return (vendor == 0x046d && in(kLogitech)) || (vendor == 0x256f && in(k3Dconnexion));
}

bool parse_spacemouse(std::span<const std::uint8_t> report, SpaceMouseState& state) {
  if (report.empty()) return false;
  if (report[0] == 1 && report.size() >= 13) {  // newer models send all six axes in one report
    state.push = axes_at(report, 1);
    state.twist = axes_at(report, 7);
    return true;
  }
  if (report[0] == 1 && report.size() >= 7) {
    state.push = axes_at(report, 1);
    return true;
  }
  if (report[0] == 2 && report.size() >= 7) {
    state.twist = axes_at(report, 1);
    return true;
  }
  if (report[0] == 3 && report.size() >= 2) {
    state.buttons = 0;
    for (std::size_t i = 1; i < std::min<std::size_t>(report.size(), 5); ++i) {
      state.buttons |= static_cast<std::uint32_t>(report[i]) << (8 * (i - 1));
    }
    return true;
  }
  return false;
}

std::unique_ptr<HapticDevice> make_spacemouse(std::unique_ptr<Link> link, const SpaceMouseControl& control, double rate,
                                              DeviceInfo identity) {
  return std::make_unique<SpaceMouse>(std::move(link), control, rate, std::move(identity));
}

extern const Driver spacemouse_driver;
const Driver spacemouse_driver{
    .scheme = "spacemouse",
    .rest = "[PATH or SERIAL][,rate|,position]",
    .about = "3Dconnexion SpaceMouse: no force, button 1 drills",
    .open = open,
    .find = find,
};

}  // namespace typodont::haptics
