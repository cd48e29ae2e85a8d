// The part of the tissue that the carver (owner of the tissue) passes to the servo. This is the base class of the data
// from which a contact model computes contact.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont::haptics {

/// Describes which state of the tissue a snapshot contains. Each tissue body derives its own type from it (a dense
/// patch of a field, a list of spheres …). The carver writes a snapshot; after ContactModel::adopt() it belongs to the
/// servo. Buffers get their size once, at set-up.
struct Snapshot {
  std::uint32_t number = 0;  // number of the snapshot, counted from 1; 0: no snapshot has been taken yet
  // 0: the snapshot is complete; otherwise the number of the snapshot from which it is a step: it contains only the
  // tissue that the servo's snapshot with this number lacks, and the servo can adopt it only instead of this snapshot
  std::uint32_t from = 0;
  std::uint64_t cuts = 0;       // index of the last cut that the snapshot contains
  std::uint32_t edits = 0;      // number of undo and redo steps made before the snapshot was taken
  std::uint64_t edited_at = 0;  // index of the last cut before the newest undo or redo step
  // m³, volume that undo steps have restored, minus the volume that redo steps have removed again
  PerTissue taken_back{};
  std::uint32_t pieces = 0;  // number of loose pieces that were removed before the snapshot was taken
  PerTissue loose{};         // m³, volume of the loose pieces that were removed
  dvec3 center_W{0, 0, 0};   // m, centre around which the snapshot was requested

  Snapshot() = default;
  Snapshot(const Snapshot&) = default;
  Snapshot(Snapshot&&) = default;
  Snapshot& operator=(const Snapshot&) = default;
  Snapshot& operator=(Snapshot&&) = default;
  virtual ~Snapshot() = default;
};

}  // namespace typodont::haptics
