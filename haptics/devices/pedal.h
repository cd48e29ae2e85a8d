// HID foot pedals: switches and rheostats.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptics/devices.h"
#include "haptics/devices/hid_descriptor.h"
#include "haptics/devices/link.h"

namespace typodont::haptics {

/// States how the reports of a pedal must be interpreted.
struct PedalKind {
  enum class Type { kKeyboard, kInfinity, kAxis } type = Type::kKeyboard;
  HidField axis;            // the axis of a rheostat; valid only if `type` is kAxis
  double dead_band = 0.04;  // at each end, of the axis
};
/// A known switch, or a rheostat by its descriptor; empty: neither.
std::optional<PedalKind> pedal_kind(std::uint16_t vendor, std::uint16_t product,
                                    std::span<const std::uint8_t> descriptor);
/// 0 to 1; empty: not in this report.
std::optional<double> pedal_value(const PedalKind& kind, std::span<const std::uint8_t> report);

/// An open pedal. After set-up, only the servo thread uses it.
class Pedal {
 public:
  Pedal(std::unique_ptr<Link> link, PedalKind kind) : link_(std::move(link)), kind_(kind) {}
  /// Newest, without waiting; 0 if gone.
  double value() noexcept;
  bool lost() const noexcept { return lost_; }

 private:
  std::unique_ptr<Link> link_;
  PedalKind kind_;
  double value_ = 0;
  bool lost_ = false;
};

std::vector<FoundDevice> find_pedals();
/// "auto" or "": first that opens, or null; else path or serial number. Throws Error.
std::unique_ptr<Pedal> open_pedal(const std::string& which);
/// The larger of foot and hand. `open_again` reopens; empty: it stays gone.
std::unique_ptr<HapticDevice> with_pedal(std::unique_ptr<HapticDevice> hand, std::unique_ptr<Pedal> pedal,
                                         std::function<std::unique_ptr<Pedal>()> open_again = {});

}  // namespace typodont::haptics
