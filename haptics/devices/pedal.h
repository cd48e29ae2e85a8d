// Foot pedals over HID: switches and rheostats start and modulate the drill.
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

/// How a pedal's reports are read.
struct PedalKind {
  enum class Type { kKeyboard, kInfinity, kAxis } type = Type::kKeyboard;
  HidField axis;            // of kAxis
  double dead_band = 0.04;  // of the axis's range, at each end
};
/// A known foot switch, or a rheostat by its report descriptor; nothing for other devices.
std::optional<PedalKind> pedal_kind(std::uint16_t vendor, std::uint16_t product,
                                    std::span<const std::uint8_t> descriptor);
/// 0..1; nothing when the report does not speak of the pedal.
std::optional<double> pedal_value(const PedalKind& kind, std::span<const std::uint8_t> report);

/// Servo thread after set-up.
class Pedal {
 public:
  Pedal(std::unique_ptr<Link> link, PedalKind kind) : link_(std::move(link)), kind_(kind) {}
  /// The newest value, without waiting. 0 once the pedal is gone.
  double value() noexcept;
  bool lost() const noexcept { return lost_; }

 private:
  std::unique_ptr<Link> link_;
  PedalKind kind_;
  double value_ = 0;
  bool lost_ = false;
};

std::vector<FoundDevice> find_pedals();
/// "auto" or "": the first that may be opened, or nothing; otherwise by path or serial. Throws Error.
std::unique_ptr<Pedal> open_pedal(const std::string& which);
/// A hand whose pedal is the foot's, or its own button where that is pressed further. `open_again`: looks for a pedal
/// that was pulled out; empty: it stays out.
std::unique_ptr<HapticDevice> with_pedal(std::unique_ptr<HapticDevice> hand, std::unique_ptr<Pedal> pedal,
                                         std::function<std::unique_ptr<Pedal>()> open_again = {});

}  // namespace typodont::haptics
