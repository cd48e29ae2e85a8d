// Channel for patches from the carver to the servo. Copying a patch takes the carver some time, and meanwhile the
// servo continues to cut. The new patch lacks these cuts, and the servo would have to repeat all of them in one tick.
// So the servo leaves such a patch in the channel for a few milliseconds, while the carver adds the cuts.
#pragma once

#include <memory>

#include "engine/base/clock.h"
#include "engine/base/latest.h"
#include "haptics/carver.h"

namespace typodont::haptics {

/// Connects one carver thread and one servo thread. Neither waits; the servo's side is lock-free (Latest).
class PatchExchange {
 public:
  /// `carver` makes the empty snapshots; it need not outlive this call.
  explicit PatchExchange(const Carver& carver) : way_([&] { return carver.make_snapshot(); }) {}

  // Carver's thread.
  /// Copies a patch from the tissue and offers it to the servo.
  void offer(Carver& carver, const dvec3& center_W);
  /// Adds the missing cuts to the offered patch. `held`: number of the servo's patch (ServoTick::patch). Returns false
  /// if no patch is offered; while it returns true, the carver should not sleep.
  bool keep_up(Carver& carver, std::uint32_t held);

  // Servo's thread.
  /// The patch that the servo should adopt now; null: none. `cuts`: number of cuts so far; `t`: ns, any steady clock.
  Snapshot* take(const Snapshot& held, std::uint64_t cuts, Nanos t) noexcept;

 private:
  /// Identifies the state of the tissue: a patch that only lacks cuts differs from a patch of edited tissue. The
  /// servo must adopt a patch of edited tissue unchanged, because the servo then repeats the later cuts itself and
  /// counts their volume differently.
  struct Tissue {
    std::uint32_t edits = 0, pieces = 0;
    bool operator==(const Tissue&) const = default;
  };
  static Tissue tissue_of(const Snapshot& patch) { return {patch.edits, patch.pieces}; }

  Latest<std::unique_ptr<Snapshot>> way_;
  // Members of the carver's thread.
  alignas(64) std::uint32_t offered_ = 0;  // number of the offered patch; 0: none
  std::uint64_t offered_cuts_ = 0;
  Tissue offered_tissue_, held_tissue_;
  // Members of the servo's thread.
  alignas(64) Nanos waiting_since_ = 0;  // ns, time at which the wait began; 0: not waiting
};

}  // namespace typodont::haptics
