// What the carver passes to the servo; base of the models' data.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont::haptics {

/// Which state it holds. Bodies derive theirs (patch, spheres …). Written by the carver, the servo's after
/// ContactModel::adopt(). Buffers get their size at set-up.
struct Snapshot {
  std::uint32_t number = 0;  // from 1; 0: none yet
  // 0: complete; otherwise a step from that snapshot, with what it lacks, adoptable only in its place
  std::uint32_t from = 0;
  std::uint64_t cuts = 0;       // last cut that it contains
  std::uint32_t edits = 0;      // undo and redo before it
  std::uint64_t edited_at = 0;  // last cut before the newest undo or redo
  // m³ restored by undo, minus removed again by redo
  PerTissue taken_back{};
  std::uint32_t pieces = 0;  // loose pieces removed before it
  PerTissue loose{};         // m³ of these
  dvec3 center_W{0, 0, 0};   // m, centre around which the snapshot was requested

  Snapshot() = default;
  Snapshot(const Snapshot&) = default;
  Snapshot(Snapshot&&) = default;
  Snapshot& operator=(const Snapshot&) = default;
  Snapshot& operator=(Snapshot&&) = default;
  virtual ~Snapshot() = default;
};

}  // namespace typodont::haptics
