// The code that the servo and the carver run in every session, from their input to their event
// logs. Live sessions, sessions on one thread and programs that use the library share it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "engine/app/event_logs.h"
#include "haptics/carver.h"
#include "haptics/patch_exchange.h"
#include "haptics/servo.h"

namespace typodont {

/// Writes the soft gum's changes at regular intervals. Never allocates.
class GumWriter {
 public:
  /// `gum`: null if the gum is rigid. `rate`: servo ticks per second.
  GumWriter(haptics::SoftTissue* gum, EventLog<ServoEvent>& event_log, double rate)
      : gum_(gum), event_log_(event_log), interval_(std::max<std::uint64_t>(1, std::llround(kInterval * rate))) {}
  /// Counts a tick and, if an update is due, writes the soft gum's changes. Call before this tick is written.
  void tick() noexcept;

 private:
  haptics::SoftTissue* gum_;
  EventLog<ServoEvent>& event_log_;
  static constexpr double kInterval = 0.016;  // s, time between two updates of the drawn soft gum
  const std::uint64_t interval_;              // ticks between two updates of the drawn soft gum
  std::uint64_t ticks_ = 0;
  std::size_t wounds_ = 0;  // number of the gum's wounds in the event log
};

/// Writes the servo's event log. Servo thread only; never allocates.
class ServoSide {
 public:
  ServoSide(haptics::Servo& servo, EventLog<ServoEvent>& event_log, double rate)
      : servo_(servo), event_log_(event_log), gum_(servo.soft(), event_log, rate) {}
  /// If the carver offers a tissue patch that the servo must use from this tick on, adopts it. `t`: any steady clock,
  /// ns.
  void take_patch(haptics::PatchExchange& patches, Nanos t) noexcept;
  /// Writes to the event log that the servo uses a new tissue patch from the next tick on.
  void write(const PatchUse& use) noexcept { event_log_.write(use); }
  /// Writes a tick and its cut. `cut` is null if no cut was made.
  void write(const ServoTick& tick, const Cut* cut) noexcept;

 private:
  haptics::Servo& servo_;
  EventLog<ServoEvent>& event_log_;
  GumWriter gum_;
  std::uint64_t ticks_ = 0, cuts_ = 0;
};

/// Repeats the servo's cuts on the whole tissue, and writes the carver's event log. Carver thread only.
class CarverSide {
 public:
  /// `start`: state of the tool before the first tick.
  CarverSide(haptics::Carver& carver, haptics::PatchExchange& patches, EventLogs& event_logs,
             const ServoTick& start = {})
      : carver_(carver), patches_(patches), event_log_(event_logs.carver), servo_(event_logs.servo), tick_(start) {}

  struct Read {
    bool tick = false, cut = false;
  };
  /// Repeats the servo's new cuts on the tissue: up to an undo, redo or separated piece that the servo must adopt
  /// first; with `to_end`, all cuts. Calls `each(cut)` after each cut. Throws RunFailure if a cut was lost.
  template <class Each>
  Read follow(Each&& each, bool to_end = false) {
    Read found;
    for (ServoEvent event; (to_end || !edit_waits()) && servo_.next(event);) {
      require_whole();
      if (const auto* const cut = std::get_if<Cut>(&event)) {
        carver_.apply(*cut);
        each(*cut);
        found.cut = true;
        if (carver_.edited()) offer(/*due_only=*/false);  // a cut separated a piece of tissue from its body
      } else if (const auto* const tick = std::get_if<ServoTick>(&event)) {
        tick_ = *tick;
        found.tick = true;
      }
    }
    return found;
  }
  /// Adds the new cuts to the tissue patch that the servo has not yet adopted, and writes separated pieces of tissue
  /// to the event log. True if there is such a patch.
  bool keep_up();
  /// Writes the pieces of tissue that the last cuts separated to the event log.
  void write_pieces();
  /// Offers a tissue patch around the tool to the servo. `due_only`: only if a new one is due. True if a patch was
  /// offered.
  bool offer(bool due_only);
  /// Undoes or redoes a stroke, and at once offers the resulting tissue patch to the servo. False: no such stroke.
  bool edit(bool redo);
  /// True if the servo has not yet adopted an undo, a redo or a separated piece of tissue.
  bool edit_waits() const { return patches_.edit_waits(); }
  /// Newest tick. All cuts up to it have been repeated.
  const ServoTick& tick() const { return tick_; }

 private:
  void require_whole() const;

  haptics::Carver& carver_;
  haptics::PatchExchange& patches_;
  EventLog<CarverEvent>& event_log_;
  EventLog<ServoEvent>::Reader servo_;
  ServoTick tick_;
};

/// Undoes or redoes a stroke at the session time t, and writes this to the carver's event log. False if there is no
/// such stroke.
bool edit_stroke(haptics::Carver& carver, bool redo, Nanos t, EventLog<CarverEvent>* event_log);

}  // namespace typodont
