// Foot pedals with HID: switches and rheostats that start the drill and control its speed.
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
  double dead_band = 0.04;  // width of the dead band at each end of the axis, as a fraction of the axis's range
};
/// Recognises a known foot switch by its vendor and product numbers, or a rheostat by its report descriptor. Returns no
/// value for other devices.
std::optional<PedalKind> pedal_kind(std::uint16_t vendor, std::uint16_t product,
                                    std::span<const std::uint8_t> descriptor);
/// Returns the pedal's value, from 0 (released) to 1, or no value if the report does not contain it.
std::optional<double> pedal_value(const PedalKind& kind, std::span<const std::uint8_t> report);

/// An open pedal. After set-up, only the servo thread uses it.
class Pedal {
 public:
  Pedal(std::unique_ptr<Link> link, PedalKind kind) : link_(std::move(link)), kind_(kind) {}
  /// Returns the newest value, from 0 (released) to 1, without waiting. It is 0 if the pedal is disconnected.
  double value() noexcept;
  bool lost() const noexcept { return lost_; }

 private:
  std::unique_ptr<Link> link_;
  PedalKind kind_;
  double value_ = 0;
  bool lost_ = false;
};

std::vector<FoundDevice> find_pedals();
/// Opens a pedal. If `which` is "auto" or "", it opens the first pedal that can be opened, or returns null. Otherwise
/// `which` is a path or a serial number. Throws Error.
std::unique_ptr<Pedal> open_pedal(const std::string& which);
/// Combines a hand with a foot pedal. The pedal value of the result is the larger one of the foot pedal's value and the
/// hand's own button. `open_again` reopens a pedal that was disconnected; if it is empty, the pedal stays disconnected.
std::unique_ptr<HapticDevice> with_pedal(std::unique_ptr<HapticDevice> hand, std::unique_ptr<Pedal> pedal,
                                         std::function<std::unique_ptr<Pedal>()> open_again = {});

}  // namespace typodont::haptics
