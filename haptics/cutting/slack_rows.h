// Stores the slack of the samples in a column of blocks: the distance that the head must move before a sample can
// change. The path for which a list of groups of samples is valid is divided into stages. This file also computes the
// first stage in which a group can change. Private to haptics/cutting.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "haptics/cut_front.h"
#include "haptics/lanes.h"

namespace typodont::haptics {

/// The slack of the samples of 16 rows. The slack of a sample is the distance (voxels) by which the head must approach
/// it before it can change.
class SlackRows {
 public:
  static constexpr int kStretch = 64;  // number of samples of a row that are listed together

  /// Stores the slack (motion until a sample can change) of eight samples of a row.
  TYPODONT_INLINE void put(int row, int z, const F8& slack) {
    std::memcpy(rows_ + row * kRow + z, &slack, sizeof slack);
  }
  /// Returns the smallest slack (motion until a sample can change) among sixteen samples of a row, from index z on.
  /// Only samples that are marked in `which` count, because the slack of other samples may not have been stored.
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
  // number of samples per stored row; larger than kStretch, because a group may extend beyond the listed samples
  static constexpr int kRow = kStretch + 16;
  static constexpr float kNever = 1e9f;

  float rows_[16 * kRow];
};

/// A list of groups of samples is valid while the head moves by `ahead` (voxels). This motion is divided into
/// CutFront::kStages equal stages. Returns the first stage in which a group of samples with this slack can change.
inline int stage_of(float slack, float ahead) {
  const float stage = slack / ahead * CutFront::kStages;
  return stage < 1 ? 0 : std::min(static_cast<int>(stage), CutFront::kStages - 1);
}

}  // namespace typodont::haptics
