// The label of a voxel in a patch (copied tissue) or volume: one byte that states the voxel's tissue. The label of a
// filled voxel also states the label that the voxel had before the filling. So a cavity gets its old labels back when
// the filling is removed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"

namespace typodont::haptics {

inline constexpr int kBeforeShift = 4;
inline constexpr std::uint8_t kShown = 0x0f;
static_assert(kTissueCount < kShown);

inline Tissue shown(Tissue label) noexcept {
  return static_cast<Tissue>(static_cast<std::uint8_t>(label) & kShown);
}
inline bool is_filled(Tissue label) noexcept {
  return static_cast<std::uint8_t>(label) > kShown;
}

/// Returns the new label of an air voxel that a filling has covered or touched. `label`: its label until now;
/// `filling`: tissue of the filling.
inline Tissue filled(Tissue label, Tissue filling) noexcept {
  const int before = is_filled(label) ? static_cast<std::uint8_t>(label) >> kBeforeShift : static_cast<int>(label) + 1;
  return static_cast<Tissue>(before << kBeforeShift | static_cast<int>(filling));
}
/// Returns the label that the voxel had before the filling.
inline Tissue emptied(Tissue label) noexcept {
  return is_filled(label) ? static_cast<Tissue>((static_cast<std::uint8_t>(label) >> kBeforeShift) - 1) : label;
}

/// If a filling was removed here, gives the voxel its former label again: the voxel must be air, and none of its 26
/// neighbours may be solid filling. The result depends only on distances and labels. Returns true if the label changed.
inline bool restore_label(const float* distance, Tissue* label, std::ptrdiff_t at, std::ptrdiff_t stride_x,
                          std::ptrdiff_t stride_y) noexcept {
  if (!is_filled(label[at]) || distance[at] <= 0) return false;
  const Tissue before = emptied(label[at]);
  // the voxel lies partly inside the surface and still contains some tissue, so its label cannot become air
  if (before == Tissue::kAir && distance[at] < 0.5f) return false;
  for (std::ptrdiff_t x = -stride_x; x <= stride_x; x += stride_x) {
    for (std::ptrdiff_t y = -stride_y; y <= stride_y; y += stride_y) {
      for (std::ptrdiff_t i = at + x + y - 1; i <= at + x + y + 1; ++i) {
        if (is_filled(label[i]) && distance[i] <= 0) return false;
      }
    }
  }
  label[at] = before;
  return true;
}

/// Applies restore_label() to a box of voxels. The arrays must contain one more sample on every side of the box. One
/// call after several cuts gives the same result as one call after each cut. Returns true if any label changed.
inline bool restore_labels(const glm::ivec3& size, const float* distance, Tissue* label, std::ptrdiff_t stride_x,
                           std::ptrdiff_t stride_y) noexcept {
  bool changed = false;
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      const std::ptrdiff_t row = x * stride_x + y * stride_y;
      for (int z = 0; z < size.z; ++z) {
        if (z + 8 <= size.z) {  // a quick test of eight voxels at once, because most voxels contain no filling
          std::uint64_t eight;
          std::memcpy(&eight, label + row + z, sizeof eight);
          if (!(eight & 0xf0f0f0f0f0f0f0f0u)) {
            z += 7;
            continue;
          }
        }
        changed |= restore_label(distance, label, row + z, stride_x, stride_y);
      }
    }
  }
  return changed;
}

}  // namespace typodont::haptics
