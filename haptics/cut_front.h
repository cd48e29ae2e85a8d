// What of a patch the next cuts can still change. The field falls behind a head and stands still ahead of it: a sample that
// lies `slack` voxels below what the head would make of it cannot change before the head has come that far. So each
// block of voxels knows on which mile of the head's way it is to be looked at again, and most cuts look at the shell
// before the head alone.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Of one tool in one patch and its successors; blocks of 4 × 4 × 8 voxels, z fastest. Buffers are sized once, at set-up.
class CutFront {
 public:
  /// Large enough for any of these tools.
  CutFront(std::span<const Tool> tools, double voxel);

  /// Groups of the same kind, one after the other.
  struct Run {
    int kind, from, to;
  };

  /// To be called when anything but the cuts of this tool lowered the field: fillings, strokes taken back, another tool.
  void forget() noexcept { known_ = false; }

 private:
  friend class Sweep;

  static constexpr int kRows = 4, kDeep = 8;
  static constexpr double kRound = 512;  // voxels of way after which counting starts anew, so that floats keep their digits
  static constexpr float kNever = 1e9f;
  static constexpr int kKinds = 20;  // of groups, at most
  static constexpr double kListed = 0.5;      // voxels of way for which what may change is listed …
  static constexpr double kMostListed = 0.2;  // … unless the head takes less than a few sweeps for that

  /// Groups of eight samples along z that the head may change before its way is `until`: first sample and where it
  /// lies in the patch.
  struct Groups {
    glm::ivec3 origin{0}, patch_lo{0};  // voxel from which they count; of the patch they were listed in
    std::vector<float> x, y;
    std::vector<std::int32_t> z, at;
    int count = 0;
    double until = -1;
    int room() const { return static_cast<int>(x.size()) - 32; }

    // Of a head that is no ball they are sorted by the pieces of its meridian that can be the closest.
    struct Found {
      float x, y;
      std::int32_t z, at;
      int kind;
    };
    std::vector<Found> found;
    std::array<Run, kKinds> runs;
    int run_count = 0;
    void sort(int listed) noexcept;
  };

  /// Whether there is room for all blocks around lo..hi (voxels).
  bool holds(const glm::ivec3& lo, const glm::ivec3& hi) const noexcept;
  /// The head comes to `X_V` (voxels); `way`: of its farthest point.
  void come_to(const Pose& X_V, double way) noexcept;
  /// Makes room for the blocks around lo..hi.
  void move_around(const glm::ivec3& lo, const glm::ivec3& hi) noexcept;
  float* due(const glm::ivec3& block) noexcept {
    const glm::ivec3 at = block - first_;
    return due_.data() + (at.x * size_.y + at.y) * size_.z + at.z;
  }

  glm::ivec3 size_{0};         // blocks
  glm::ivec3 first_{0};        // block at the beginning of due_
  std::vector<float> due_, moved_;  // way at which a block may change; the same while they are shifted
  Groups groups_;
  std::vector<float> heights_;  // see ball.cpp
  bool known_ = false;
  double way_ = 0;  // voxels so far
  Pose X_V_;        // where the head is, voxels
};

}  // namespace typodont::haptics
