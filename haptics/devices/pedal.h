// HID foot pedals: switches, and rheostats with a continuous position.
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
  HidField axis;            // a rheostat's axis; valid only if `type` is kAxis
  double dead_band = 0.04;  // part of the axis range ignored at each end
};
/// Recognises a known switch by its ids, or a rheostat by its report descriptor; nullopt: neither.
std::optional<PedalKind> pedal_kind(std::uint16_t vendor, std::uint16_t product,
                                    std::span<const std::uint8_t> descriptor);
/// Position of the pedal, 0 to 1; nullopt if this report does not contain it.
std::optional<double> pedal_value(const PedalKind& kind, std::span<const std::uint8_t> report);

/// An open pedal. Used only by the servo thread.
class Pedal {
 public:
  Pedal(std::unique_ptr<Link> link, PedalKind kind) : link_(std::move(link)), kind_(kind) {}
  /// Returns the newest position without waiting; 0 if the pedal is lost.
  double value() noexcept;
  bool lost() const noexcept { return lost_; }

 private:
  std::unique_ptr<Link> link_;
  PedalKind kind_;
  double value_ = 0;
  bool lost_ = false;
};

std::vector<FoundDevice> find_pedals();
/// Opens a pedal by path or serial number; "auto" or "": the first that can be opened, or null. Throws Error.
std::unique_ptr<Pedal> open_pedal(const std::string& which);
/// Adds the pedal to the hand; the larger of both pedal values counts. `open_again` reopens a lost pedal; empty: it
/// stays lost.
std::unique_ptr<HapticDevice> with_pedal(std::unique_ptr<HapticDevice> hand, std::unique_ptr<Pedal> pedal,
                                         std::function<std::unique_ptr<Pedal>()> open_again = {});

}  // namespace typodont::haptics
