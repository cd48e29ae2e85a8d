// The way of patches from the carver to the servo. A cut-out takes the carver a while, in which the servo goes on
// cutting; what such a patch lacks the servo would have to put in itself, in one tick. So the servo leaves a patch that
// lacks cuts where it is for a few milliseconds, in which the carver brings it up to date.
#pragma once

#include <memory>

#include "engine/base/clock.h"
#include "engine/base/latest.h"
#include "haptics/carver.h"

namespace typodont::haptics {

/// One carver, one servo, each in its thread. Nobody waits: lock-free on the servo's side (Latest).
class PatchExchange {
 public:
  /// `carver` makes the empty snapshots; it need not outlive this call.
  explicit PatchExchange(const Carver& carver) : way_([&] { return carver.make_snapshot(); }) {}

  // Carver's thread.
  /// Cuts a patch out and offers it.
  void offer(Carver& carver, const dvec3& center_W);
  /// Brings what is offered up to date. `held`: number of the patch that the servo has (ServoTick::patch). False when
  /// nothing is offered any more; until then the carver had better not sleep.
  bool keep_up(Carver& carver, std::uint32_t held);

  // Servo's thread.
  /// The patch to be adopted now, or none. `cuts`: made so far; `t`: any steady clock.
  Snapshot* take(const Snapshot& held, std::uint64_t cuts, Nanos t) noexcept;

 private:
  /// What tells a patch that only lacks cuts from one of edited tissue: that one the servo is to have as it was cut
  /// out, for it repeats the cuts since, and counts what they take otherwise.
  struct Tissue {
    std::uint32_t edits = 0, pieces = 0;
    bool operator==(const Tissue&) const = default;
  };
  static Tissue tissue_of(const Snapshot& patch) { return {patch.edits, patch.pieces}; }

  Latest<std::unique_ptr<Snapshot>> way_;
  // Carver's thread.
  alignas(64) std::uint32_t offered_ = 0;  // number; 0: none
  std::uint64_t offered_cuts_ = 0;
  Tissue offered_tissue_, held_tissue_;
  // Servo's thread.
  alignas(64) Nanos waiting_since_ = 0;  // 0: not waiting
};

}  // namespace typodont::haptics
