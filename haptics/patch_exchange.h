// From carver to servo. The servo cuts on while a patch is copied, and would have to repeat these cuts in one tick. So
// it waits a few milliseconds while the carver adds them; steps (patch_step.h), where its own samples stay, are adopted
// at once.
#pragma once

#include <atomic>
#include <memory>

#include "engine/base/clock.h"
#include "engine/base/latest.h"
#include "haptics/carver.h"

namespace typodont::haptics {

/// One carver and one servo thread; nobody blocks, the servo's side is lock-free (Latest).
class PatchExchange {
 public:
  /// Uses `carver` only to create the empty snapshots.
  explicit PatchExchange(const Carver& carver) : way_([&] { return carver.make_snapshot(); }) {}

  // Functions for the carver thread.
  /// Copies a patch (the tissue around `center_W`, m) and offers it to the servo. If the servo holds the patch that was
  /// offered last, the new patch may be a step from it (Snapshot::from), which needs less copying.
  void offer(Carver& carver, const dvec3& center_W);
  /// Adds missing cuts to the offered patch. `held`: ServoTick::patch. False: none offered; while true, call again
  /// without sleeping.
  bool keep_up(Carver& carver, std::uint32_t held);

  /// The offered patch has an edit that the servo has not: no cut is applied, or the servo would not count it.
  bool edit_waits() const noexcept {
    return offered_ != 0 && offered_tissue_ != held_tissue_ && taken_.load(std::memory_order_acquire) != offered_;
  }

  // Function for the servo thread.
  /// To adopt now, or null. `cuts`: so far; `t`: ns, any steady clock. After adopt() it holds the servo's previous
  /// patch, which the next call returns to the carver for reuse.
  Snapshot* take(const Snapshot& held, std::uint64_t cuts, Nanos t) noexcept;

 private:
  /// Undo, redo and removed loose pieces: a cut may then remove another volume. With different numbers, the servo
  /// itself repeats the cuts and counts their volume.
  struct Tissue {
    std::uint32_t edits = 0, pieces = 0;
    bool operator==(const Tissue&) const = default;
  };
  static Tissue tissue_of(const Snapshot& patch) { return {patch.edits, patch.pieces}; }

  Latest<std::unique_ptr<Snapshot>> way_;
  // Carver thread: number of the offered patch; 0: none
  alignas(64) std::uint32_t offered_ = 0;
  bool offered_step_ = false;  // offered as a step: no cuts are added
  std::uint32_t held_ = 0;     // the servo's, if none is offered
  std::uint64_t offered_cuts_ = 0;
  Tissue offered_tissue_, held_tissue_;
  // Servo thread:
  alignas(64) Nanos waiting_since_ = 0;   // ns, since when it waits; 0: not
  bool adopted_ = false;                  // the last take() returned one
  std::atomic<std::uint32_t> taken_ = 0;  // number of the last one
};

}  // namespace typodont::haptics
