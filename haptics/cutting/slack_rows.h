// How far the samples of a column of blocks are from changing, and when a group of them may. Private to haptics/cutting.
#pragma once

#include <algorithm>
#include <cstring>

#include "haptics/cut_front.h"
#include "haptics/lanes.h"

namespace typodont::haptics {

/// Of 16 rows; voxels that the head may still come nearer.
class SlackRows {
 public:
  static constexpr int kStretch = 64;  // samples of a row that are listed together

  TYPODONT_KERNEL void forget() {
    for (int i = 0; i < 16 * kRow; i += 8) store(i, F8{} + kNever);
  }
  /// Of eight samples of a row.
  TYPODONT_KERNEL void put(int row, int z, const F8& slack) { store(row * kRow + z, slack); }
  /// The least of a group that begins there.
  TYPODONT_KERNEL float least(int row, int z) const {
    F8 low, high;
    std::memcpy(&low, rows_ + row * kRow + z, sizeof low);
    std::memcpy(&high, rows_ + row * kRow + z + 8, sizeof high);
    const F8 both = low < high ? low : high;
    float least = both[0];
    for (int i = 1; i < 8; ++i) least = std::min(least, both[i]);
    return least;
  }

 private:
  static constexpr int kRow = kStretch + 16;  // a group may reach beyond the stretch
  static constexpr float kNever = 1e9f;
  TYPODONT_KERNEL void store(int at, const F8& v) { std::memcpy(rows_ + at, &v, sizeof v); }

  float rows_[16 * kRow];
};

/// The stage before which nothing changes that has so much slack, of a list that lasts for `ahead`.
inline int stage_of(float slack, float ahead) {
  const float stage = slack / ahead * CutFront::kStages;
  return stage < 1 ? 0 : std::min(static_cast<int>(stage), CutFront::kStages - 1);
}

}  // namespace typodont::haptics
