#include "haptics/devices/pedal.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>

#include "engine/base/error.h"
#include "haptics/devices/fd_link.h"
#include "haptics/devices/hid.h"
#include "haptics/devices/reopener.h"

namespace typodont::haptics {

namespace {

// HID usages of a pedal, in order of preference: simulation controls (accelerator, brake, clutch), then generic axes.
constexpr std::array<std::uint32_t, 11> kAxes{0x0200c4, 0x0200c5, 0x0200bb, 0x010030, 0x010031, 0x010032,
                                              0x010033, 0x010034, 0x010035, 0x010036, 0x010037};
constexpr std::array<std::pair<std::uint16_t, std::uint16_t>, 5> kKeyboards{
    {{0x0c45, 0x7403}, {0x0c45, 0x7404}, {0x3553, 0xb001}, {0x413d, 0x2107}, {0x1a86, 0xe026}}};

class PedalHand : public HapticDevice {
 public:
  PedalHand(std::unique_ptr<HapticDevice> hand, std::unique_ptr<Pedal> pedal,
            std::function<std::unique_ptr<Pedal>()> open_again)
      : hand_(std::move(hand)), pedal_(std::move(pedal)) {
    if (open_again) reopener_.emplace(std::move(open_again));
  }
  const DeviceInfo& info() const noexcept override { return hand_->info(); }
  bool read(HandSample& sample) noexcept override {
    if (!hand_->read(sample)) return false;
    if (!pedal_ && reopener_) pedal_ = reopener_->take();
    if (!pedal_) return true;
    sample.pedal = std::max(sample.pedal, pedal_->value());
    if (pedal_->lost() && reopener_) reopener_->want(std::move(pedal_));
    return true;
  }
  void write(const dvec3& f, const dvec3& tau) noexcept override { hand_->write(f, tau); }
  std::uint32_t faults() const noexcept override { return hand_->faults(); }
  std::span<const double> joints() const noexcept override { return hand_->joints(); }
  SafetyStatus safety() noexcept override { return hand_->safety(); }
  void release() noexcept override { hand_->release(); }

 private:
  std::unique_ptr<HapticDevice> hand_;
  std::unique_ptr<Pedal> pedal_;  // null while the pedal is disconnected
  std::optional<Reopener<Pedal>> reopener_;
};

}  // namespace

std::optional<PedalKind> pedal_kind(std::uint16_t vendor, std::uint16_t product,
                                    std::span<const std::uint8_t> descriptor) {
  for (const auto& id : kKeyboards) {
    if (id == std::pair{vendor, product}) return PedalKind{PedalKind::Type::kKeyboard, {}};
  }
  if (vendor == 0x05f3 && product == 0x00ff) return PedalKind{PedalKind::Type::kInfinity, {}};
  // Accepts a simulation axis, or a generic axis if the device has at most three. This excludes most joysticks.
  const std::vector<HidField> fields = parse_descriptor(descriptor);
  std::size_t axes = 0;
  for (const HidField& f : fields) axes += std::count(kAxes.begin(), kAxes.end(), f.usage);
  for (std::size_t k = 0; k < kAxes.size(); ++k) {
    if (k >= 3 && axes > 3) break;
    const auto field = std::find_if(fields.begin(), fields.end(), [&](const HidField& f) {
      return f.usage == kAxes[k] && f.maximum > f.minimum && f.bits >= 6;
    });
    if (field != fields.end()) return PedalKind{PedalKind::Type::kAxis, *field};
  }
  return std::nullopt;
}

std::optional<double> pedal_value(const PedalKind& kind, std::span<const std::uint8_t> report) {
  switch (kind.type) {
    case PedalKind::Type::kKeyboard:
      // Report of a boot keyboard: modifiers, a reserved byte, keys. Any pressed key counts.
      if (report.size() < 3) return std::nullopt;
      return report[0] || std::any_of(report.begin() + 2, report.end(), [](std::uint8_t k) { return k != 0; }) ? 1 : 0;
    case PedalKind::Type::kInfinity:
      if (report.size() != 2) return std::nullopt;
      return report[0] & 7 ? 1 : 0;
    case PedalKind::Type::kAxis: {
      const auto value = field_value(kind.axis, report);
      if (!value) return std::nullopt;
      const double range = static_cast<double>(kind.axis.maximum) - kind.axis.minimum;
      const double fraction = (static_cast<double>(*value) - kind.axis.minimum) / range;
      return std::clamp((fraction - kind.dead_band) / (1 - 2 * kind.dead_band), 0.0, 1.0);
    }
  }
  return std::nullopt;
}

double Pedal::value() noexcept {
  for (int i = 0; i < 16 && !lost_; ++i) {  // reads all queued reports, because only the newest one counts
    std::uint8_t buffer[64];
    const int n = link_->read(buffer, 0);
    if (n == 0) break;
    if (n < 0) {
      lost_ = true;
      value_ = 0;  // a disconnected pedal counts as released
      break;
    }
    if (const auto v = pedal_value(kind_, {buffer, static_cast<std::size_t>(n)})) value_ = *v;
  }
  return value_;
}

std::vector<FoundDevice> find_pedals() {
  std::vector<FoundDevice> pedals;
  for (const HidNode& node : enumerate_hid()) {
    // Skips a mouse (usage 2) or 6-DoF mouse (usage 8).
    if (node.usage_page == 1 && (node.usage == 2 || node.usage == 8)) continue;
    const auto kind = pedal_kind(node.vendor, node.product, report_descriptor(node.path));
    if (!kind) continue;
    const bool permitted = ::access(node.path.c_str(), R_OK | W_OK) == 0;
    pedals.push_back({"", kind->type == PedalKind::Type::kAxis ? "rheostat pedal" : "foot switch",
                      node.name.empty() ? "pedal" : node.name, node.serial, node.path, 0, permitted,
                      permitted ? "" : kPermissionRemedy});
  }
  return pedals;
}

std::unique_ptr<Pedal> open_pedal(const std::string& which) {
  const bool any = which.empty() || which == "auto";
  for (const HidNode& node : enumerate_hid()) {
    const auto kind = pedal_kind(node.vendor, node.product, report_descriptor(node.path));
    if (!kind || !(any || which == node.path || which == node.serial)) continue;
    try {
      return std::make_unique<Pedal>(open_hid(node.path), *kind);
    } catch (const Error&) {
      // An error is reported only if the user named this pedal; otherwise the next pedal is tried.
      if (!any) throw;
    }
  }
  if (any) return nullptr;
  throw Error("pedal", which, "no such pedal", "the path or serial of one; see: typodont devices");
}

std::unique_ptr<HapticDevice> with_pedal(std::unique_ptr<HapticDevice> hand, std::unique_ptr<Pedal> pedal,
                                         std::function<std::unique_ptr<Pedal>()> open_again) {
  return std::make_unique<PedalHand>(std::move(hand), std::move(pedal), std::move(open_again));
}

}  // namespace typodont::haptics
