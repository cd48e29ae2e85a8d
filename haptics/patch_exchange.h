// Passes patches (copies of the tissue) from the carver, which owns the tissue, to the servo. The servo continues to
// cut during the copy. It adopts the patch a few milliseconds later, when the carver has added the missing cuts.
#pragma once

#include <atomic>
#include <memory>

#include "engine/base/clock.h"
#include "engine/base/latest.h"
#include "haptics/carver.h"

namespace typodont::haptics {

/// For one carver and one servo thread. Neither blocks; the servo's side is lock-free (Latest).
class PatchExchange {
 public:
  /// Uses `carver` only to create the empty snapshots.
  explicit PatchExchange(const Carver& carver) : way_([&] { return carver.make_snapshot(); }) {}

  // Functions for the carver thread.
  /// Copies a patch (the tissue around `center_W`, m) and offers it to the servo. If the servo holds the patch that was
  /// offered last, the new patch may contain only the changes since then (Snapshot::from), which takes less time.
  void offer(Carver& carver, const dvec3& center_W);
  /// Adds cuts that the offered tissue patch lacks. `held`: patch that the servo holds (ServoTick::patch). Returns
  /// false if no patch is offered; while true, call it again without sleeping.
  bool keep_up(Carver& carver, std::uint32_t held);

  /// Returns true if the offered tissue patch contains an undo, redo or removed piece that the servo's patch lacks.
  /// Then the carver must apply no cut, because the servo would not count its volume.
  bool edit_waits() const noexcept {
    return offered_ != 0 && offered_tissue_ != held_tissue_ && taken_.load(std::memory_order_acquire) != offered_;
  }

  // Function for the servo thread.
  /// Returns the tissue patch to adopt now, or null. `cuts`: number of the servo's cuts so far; `t`: time on any steady
  /// clock, ns. After adopt(), the object holds the servo's previous patch; the next call returns it to the carver for
  /// reuse.
  Snapshot* take(const Snapshot& held, std::uint64_t cuts, Nanos t) noexcept;

 private:
  /// Number of undos and redos, and of removed pieces. If two tissue patches differ in them, a cut may remove different
  /// volumes, so the servo itself repeats the cuts and counts the volume.
  struct Tissue {
    std::uint32_t edits = 0, pieces = 0;
    bool operator==(const Tissue&) const = default;
  };
  static Tissue tissue_of(const Snapshot& patch) { return {patch.edits, patch.pieces}; }

  Latest<std::unique_ptr<Snapshot>> way_;
  // Carver thread: serial number of the offered tissue patch; 0: no patch is offered
  alignas(64) std::uint32_t offered_ = 0;
  bool offered_step_ = false;  // true: the offered tissue patch is a step (PatchStep), to which no cuts are added
  std::uint32_t held_ = 0;     // serial number of the servo's tissue patch; valid while no patch is offered
  std::uint64_t offered_cuts_ = 0;
  Tissue offered_tissue_, held_tissue_;
  // Data of the servo thread:
  alignas(64) Nanos waiting_since_ = 0;   // ns, start of waiting for the tissue patch; 0: not waiting
  bool adopted_ = false;                  // true: the last take() returned a tissue patch
  std::atomic<std::uint32_t> taken_ = 0;  // serial number of the last tissue patch that take() returned
};

}  // namespace typodont::haptics
