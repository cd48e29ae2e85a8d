// Stores how far the head may move before the samples of a column of blocks can change. Private to haptics/cutting.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "haptics/cutting/cut_front.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics {

/// Safe travel of the samples in 16 rows: distance (voxels) that the head can move before a sample can change.
class SafeTravelRows {
 public:
  static constexpr int kStretch = 64;  // largest number of samples of a row that are listed together

  /// Stores the safe travel of eight samples: how far the head can move before each sample can change.
  TYPODONT_INLINE void put(int row, int z, const F8& safe_travel) {
    std::memcpy(rows_ + row * kRow + z, &safe_travel, sizeof safe_travel);
  }
  /// Smallest safe travel (head motion before a change) among samples z to z + 15 of a row whose bit in `which` is set.
  TYPODONT_INLINE float least(int row, int z, std::uint64_t which) const {
    const I8 bits = I8{} + static_cast<int>(which & 0xffff), one = {1, 2, 4, 8, 16, 32, 64, 128};
    F8 low, high;
    std::memcpy(&low, rows_ + row * kRow + z, sizeof low);
    std::memcpy(&high, rows_ + row * kRow + z + 8, sizeof high);
    low = (bits & one) != 0 ? low : F8{} + kNever;
    high = (bits & (one << 8)) != 0 ? high : F8{} + kNever;
    const F8 both = low < high ? low : high;
    const F4 first = __builtin_shufflevector(both, both, 0, 1, 2, 3),
             second = __builtin_shufflevector(both, both, 4, 5, 6, 7);
    const F4 least = first < second ? first : second;
    return std::min(std::min(least[0], least[1]), std::min(least[2], least[3]));
  }

 private:
  // elements per row; more than kStretch, because a group of 8 or 16 samples may extend beyond kStretch
  static constexpr int kRow = kStretch + 16;
  static constexpr float kNever = 1e9f;

  float rows_[16 * kRow];
};

/// A list of samples is valid while the head moves `ahead` voxels. This path is divided into CutFront::kStages equal
/// stages. Returns the first stage in which a sample with this safe travel can change.
inline int stage_of(float safe_travel, float ahead) {
  const float stage = safe_travel / ahead * CutFront::kStages;
  return stage < 1 ? 0 : std::min(static_cast<int>(stage), CutFront::kStages - 1);
}

}  // namespace typodont::haptics
