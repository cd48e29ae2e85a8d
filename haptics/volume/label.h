// The tissue of a voxel in one byte. A filled voxel also stores its label before the filling, so that a cavity gets its
// labels back.
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

/// Label of an air voxel after it was filled with `filling`. `label`: its label before.
inline Tissue filled(Tissue label, Tissue filling) noexcept {
  const int before = is_filled(label) ? static_cast<std::uint8_t>(label) >> kBeforeShift : static_cast<int>(label) + 1;
  return static_cast<Tissue>(before << kBeforeShift | static_cast<int>(filling));
}
/// Label that a voxel had before it was filled; the unchanged `label` if it is not filled.
inline Tissue emptied(Tissue label) noexcept {
  return is_filled(label) ? static_cast<Tissue>((static_cast<std::uint8_t>(label) >> kBeforeShift) - 1) : label;
}

/// Restores a voxel's label from before the filling, if the voxel is in air now and none of its 26 neighbours contains
/// solid filling. Depends only on distances and labels. Returns true if the label changed.
inline bool restore_label(const float* distance, Tissue* label, std::ptrdiff_t at, std::ptrdiff_t stride_x,
                          std::ptrdiff_t stride_y) noexcept {
  if (!is_filled(label[at]) || distance[at] <= 0) return false;
  const Tissue before = emptied(label[at]);
  // the voxel lies partly inside the surface, so some tissue is left in it, and it must not become air
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

/// Restores labels in a box whose arrays have one more sample on every side. One call after several cuts gives the same
/// result as a call after each. Returns true if a label changed.
inline bool restore_labels(const glm::ivec3& size, const float* distance, Tissue* label, std::ptrdiff_t stride_x,
                           std::ptrdiff_t stride_y) noexcept {
  bool changed = false;
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      const std::ptrdiff_t row = x * stride_x + y * stride_y;
      for (int z = 0; z < size.z; ++z) {
        if (z + 8 <= size.z) {  // tests eight labels at once, because most contain no filling
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
