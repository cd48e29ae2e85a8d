// State of the tissue that the carver passes to the servo. Base class of the snapshots of all contact models.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont::haptics {

/// Describes which state of the tissue a snapshot contains. The carver writes it; after ContactModel::adopt() it
/// belongs to the servo. Buffers get their size at set-up.
struct Snapshot {
  std::uint32_t number = 0;  // number of the snapshot, from 1; 0: empty
  // 0: complete snapshot. Otherwise: only the changes since the snapshot with this number, the only one it can replace.
  std::uint32_t from = 0;
  std::uint64_t cuts = 0;       // number of the last cut that the snapshot contains
  std::uint32_t edits = 0;      // number of undos and redos before the snapshot
  std::uint64_t edited_at = 0;  // number of the last cut before the newest undo or redo
  // m³, volume restored by undos, minus volume removed by redos
  PerTissue taken_back{};
  std::uint32_t pieces = 0;  // number of loose pieces removed before the snapshot
  PerTissue loose{};         // m³, volume of the loose pieces removed before the snapshot
  dvec3 center_W{0, 0, 0};   // m, centre around which the snapshot was requested

  Snapshot() = default;
  Snapshot(const Snapshot&) = default;
  Snapshot(Snapshot&&) = default;
  Snapshot& operator=(const Snapshot&) = default;
  Snapshot& operator=(Snapshot&&) = default;
  virtual ~Snapshot() = default;
};

}  // namespace typodont::haptics
