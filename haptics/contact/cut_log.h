// The last cuts of a servo, so that a fresh patch that lacks some of them is brought up to date.
#pragma once

#include <algorithm>
#include <array>
#include <climits>
#include <cstdint>
#include <utility>

#include "engine/contract/contact.h"

namespace typodont::haptics {

/// Cuts and fillings by their index, the oldest overwritten. Servo thread; never allocates.
class CutLog {
 public:
  static constexpr int kLength = 8192;  // cuts a late patch may lack

  /// The cut itself, to be made once more in a patch that was edited.
  struct Made {
    Pose X_WA, X_WB;
    std::uint32_t tool = 0;
    bool continues = false;
    double fill_radius = 0;  // m, of a filling around X_WA, pressed by a head at X_WB
    PerTissue removed{};     // voxels³; less than nothing by a filling
  };

  /// `lo`, `hi`: voxels that it may have changed.
  void add(std::uint64_t index, const glm::ivec3& lo, const glm::ivec3& hi, const Made& cut) noexcept {
    boxes_[index % kLength] = {lo, hi, cut.fill_radius > 0};
    made_[index % kLength] = cut;
    last_ = index;
  }
  const Made& made(std::uint64_t index) const noexcept { return made_[index % kLength]; }
  std::uint64_t last() const noexcept { return last_; }
  /// The oldest cut after `index` that is still known.
  std::uint64_t first_after(std::uint64_t index) const noexcept {
    return std::max(index, last_ >= kLength ? last_ - kLength : 0) + 1;
  }
  /// Union of the boxes of cuts after `index`; everything when that reaches back too far. False when there is none.
  /// `filled`: whether there was a filling among them.
  bool since(std::uint64_t index, glm::ivec3& lo, glm::ivec3& hi, bool& filled) const noexcept {
    if (index >= last_) return false;
    filled = last_ - index >= kLength;
    lo = glm::ivec3(INT_MAX), hi = glm::ivec3(INT_MIN);
    if (last_ - index >= kLength) {
      std::swap(lo, hi);
      return true;
    }
    for (std::uint64_t i = index + 1; i <= last_; ++i) {
      const Box& box = boxes_[i % kLength];
      lo = glm::min(lo, box.lo);
      hi = glm::max(hi, box.hi);
      filled |= box.filled;
    }
    return true;
  }

 private:
  struct Box {
    glm::ivec3 lo{0}, hi{0};
    bool filled = false;
  };
  std::array<Box, kLength> boxes_;
  std::array<Made, kLength> made_;
  std::uint64_t last_ = 0;
};

}  // namespace typodont::haptics
