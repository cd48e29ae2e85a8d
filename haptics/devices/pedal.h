// Foot pedals over HID: switches and rheostats that start the drill and control its speed.
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

/// Interpretation of a pedal's reports.
struct PedalKind {
  enum class Type { kKeyboard, kInfinity, kAxis } type = Type::kKeyboard;
  HidField axis;            // the axis of a rheostat; valid for kAxis
  double dead_band = 0.04;  // fraction of the axis's range, dead band at each end
};
/// Recognises a known foot switch by its ids, or a rheostat by its report descriptor; nullopt for other devices.
std::optional<PedalKind> pedal_kind(std::uint16_t vendor, std::uint16_t product,
                                    std::span<const std::uint8_t> descriptor);
/// The pedal's value, 0..1; nullopt if the report contains no value of the pedal.
std::optional<double> pedal_value(const PedalKind& kind, std::span<const std::uint8_t> report);

/// Used by the servo thread after set-up.
class Pedal {
 public:
  Pedal(std::unique_ptr<Link> link, PedalKind kind) : link_(std::move(link)), kind_(kind) {}
  /// The newest value, without waiting. 0 if the pedal is disconnected.
  double value() noexcept;
  bool lost() const noexcept { return lost_; }

 private:
  std::unique_ptr<Link> link_;
  PedalKind kind_;
  double value_ = 0;
  bool lost_ = false;
};

std::vector<FoundDevice> find_pedals();
/// Opens a pedal. "auto" or "": the first pedal that can be opened, or null; otherwise `which` is a path or a serial
/// number. Throws Error.
std::unique_ptr<Pedal> open_pedal(const std::string& which);
/// Combines a hand with a foot pedal: the combined value is the larger of the pedal's and the hand's own button.
/// `open_again` reopens a pedal that was disconnected; empty: the pedal stays disconnected.
std::unique_ptr<HapticDevice> with_pedal(std::unique_ptr<HapticDevice> hand, std::unique_ptr<Pedal> pedal,
                                         std::function<std::unique_ptr<Pedal>()> open_again = {});

}  // namespace typodont::haptics
