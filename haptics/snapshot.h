// The part of the tissue that the carver passes to the servo: base class of the data in which contact models compute.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont::haptics {

/// Describes which tissue a snapshot contains. A tissue body derives its own snapshot type from it (the dense patch of
/// the field models, a list of spheres …). The carver writes it, the servo owns it from ContactModel::adopt() on.
/// Buffers are sized once, at set-up.
struct Snapshot {
  std::uint32_t number = 0;     // 1, 2, 3 …; 0: empty, no snapshot has been taken yet
  std::uint64_t cuts = 0;       // index of the last cut that the snapshot contains
  std::uint32_t edits = 0;      // number of undo and redo steps before the snapshot was taken
  std::uint64_t edited_at = 0;  // index of the last cut before the newest undo or redo step
  PerTissue taken_back{};    // m³, volume that all undo steps restored, minus the volume that redo steps removed again
  std::uint32_t pieces = 0;  // number of loose pieces that were removed before the snapshot was taken
  PerTissue loose{};         // m³, volume of the removed pieces
  dvec3 center_W{0, 0, 0};   // m, requested centre of the snapshot

  Snapshot() = default;
  Snapshot(const Snapshot&) = default;
  Snapshot(Snapshot&&) = default;
  Snapshot& operator=(const Snapshot&) = default;
  Snapshot& operator=(Snapshot&&) = default;
  virtual ~Snapshot() = default;
};

}  // namespace typodont::haptics
