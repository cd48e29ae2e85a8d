// Passes patches (copies of the tissue around the tool) from the carver to the servo. While the carver copies a patch,
// the servo continues to cut. The new patch lacks these cuts, and the servo would have to repeat all of them in one
// tick. Therefore the servo leaves the patch in the channel for a few milliseconds, while the carver adds these cuts.
// But most patches are steps from the servo's patch (patch_step.h). In these, the servo keeps its samples with all its
// cuts, so it adopts them at once.
#pragma once

#include <memory>

#include "engine/base/clock.h"
#include "engine/base/latest.h"
#include "haptics/carver.h"

namespace typodont::haptics {

/// Connects one carver thread and one servo thread. Neither blocks; the servo's side is lock-free (class Latest).
class PatchExchange {
 public:
  /// Uses `carver` only to create the empty snapshots.
  explicit PatchExchange(const Carver& carver) : way_([&] { return carver.make_snapshot(); }) {}

  // Functions for the carver thread.
  /// Copies a patch (the tissue around `center_W`, m) and offers it to the servo. If the servo holds the patch that was
  /// offered last, the new patch may be a step from it (Snapshot::from), which needs less copying.
  void offer(Carver& carver, const dvec3& center_W);
  /// Adds the missing cuts to the patch (copy of the tissue) that is offered to the servo. `held`: number of the patch
  /// that the servo uses (ServoTick::patch). Returns false if no patch is offered. While it returns true, the carver
  /// should call it again without sleeping.
  bool keep_up(Carver& carver, std::uint32_t held);

  // Function for the servo thread.
  /// Returns the patch (copy of the tissue) that the servo must adopt now, or null. `cuts`: number of cuts so far; `t`:
  /// time of any steady clock, ns. After adopt() the returned object contains the servo's previous patch. The next call
  /// gives this patch to the carver, which reuses it, because it already contains most of the samples.
  Snapshot* take(const Snapshot& held, std::uint64_t cuts, Nanos t) noexcept;

 private:
  /// Identifies the edits of the tissue that are not cuts: undo, redo and the removal of loose pieces. After such an
  /// edit, the same cut may remove another volume. So if the offered patch and the servo's patch have different
  /// numbers, the carver must not add cuts to the offered patch. The servo itself then repeats these cuts, and counts
  /// the volume that they remove.
  struct Tissue {
    std::uint32_t edits = 0, pieces = 0;
    bool operator==(const Tissue&) const = default;
  };
  static Tissue tissue_of(const Snapshot& patch) { return {patch.edits, patch.pieces}; }

  Latest<std::unique_ptr<Snapshot>> way_;
  // The next members are used by the carver thread.
  // number of the patch (copy of the tissue) that is offered to the servo; 0: none
  alignas(64) std::uint32_t offered_ = 0;
  bool offered_step_ = false;  // true: the offered patch is a step, to which no cuts must be added
  std::uint32_t held_ = 0;     // number of the patch that the servo holds, if no other patch is offered
  std::uint64_t offered_cuts_ = 0;
  Tissue offered_tissue_, held_tissue_;
  // The next members are used by the servo thread.
  alignas(64) Nanos waiting_since_ = 0;  // ns, time at which the servo began to wait; 0: it does not wait
  bool adopted_ = false;                 // true: the last call of take() returned a patch (copy of the tissue)
};

}  // namespace typodont::haptics
