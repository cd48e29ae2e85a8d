// Which samples of a patch the next cuts can change. A sample whose value is `slack` voxels above its depth in the head
// cannot change before the head has moved that far. So each block of voxels stores the path length at which it must be
// examined again, and most cuts touch only the samples just ahead of the head. These are listed for the next voxel of
// path, in parts that are renewed by turns.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// How many samples along z this processor raises at once: 8 or 16.
int widest_group() noexcept;

/// For one tool, in one patch and those that follow it. Blocks are 4 × 4 × 8 voxels, z fastest. Buffers are sized once,
/// at set-up.
class CutFront {
 public:
  /// Large enough for any of these tools. `lanes`: of a group; which of them this processor has changes no bit.
  CutFront(std::span<const Tool> tools, double voxel, int lanes = widest_group());

  /// The lists are kept in parts, which are renewed by turns: part i holds every n-th layer of blocks along x. The
  /// larger the head, the more parts, so that the ticks in which a part is renewed stay short beside the others.
  int parts() const noexcept { return static_cast<int>(parts_.size()); }

  /// Consecutive groups of the same kind. `narrow`: only the first kNarrowest samples of each can change, fewer than
  /// there are lanes. None of them changes before the head has moved `stage` eighths of the list's lifetime (always 0
  /// for heads that are no balls).
  struct Run {
    int kind;
    bool narrow;
    int stage, from, to;
  };
  static constexpr int kStages = 8, kNarrowest = 8;

  /// A group as it is found.
  struct Found {
    float x, y;
    std::int32_t z, at;
    int kind, stage;
    bool narrow;
    std::uint8_t length, label;
  };

  /// Groups as arrays, one per property. A few elements beyond the last may be read.
  struct Listed {
    float* x;  // from the origin of the groups
    float* y;
    std::int32_t* z;
    std::int32_t* at;      // from the sample at that origin
    std::uint8_t* length;  // samples that may change …
    std::uint8_t* label;   // … and what they are
  };

  /// Call it when anything other than this tool's cuts lowered the field: fillings, undo, another tool.
  void forget() noexcept { known_ = false; }
  /// Where the groups that are listed now begin, from the first sample of a patch of edge n that begins at that voxel,
  /// and how wide they are.
  struct Place {
    std::ptrdiff_t at;
    int lanes;
  };
  std::vector<Place> listed_in(const glm::ivec3& patch_lo, int n) const;
  /// Call it when only labels changed.
  void list_anew() noexcept { drop_listed(); }

 private:
  friend class Sweep;

  static constexpr int kRows = 4, kDeep = 8;
  static constexpr double kRound =
      512;  // voxels of way after which counting starts anew, so that floats keep their digits
  static constexpr float kNever = 1e9f;
  static constexpr int kKinds = 20;  // of groups, at most
  // Lifetime of a list, voxels of path. A longer one is renewed less often, but holds more groups, and more of them
  // near several pieces of the head's outline.
  static constexpr double kListedOfBall = 1, kListedOfHead = 0.75;
  static constexpr double kMostListed = 0.2;  // voxels a sweep; a faster head outruns its lists, so it gets none

  /// Groups of samples along z that the head may change before its way is `until`: first sample, where it lies in the
  /// patch, how many may change, and their tissue.
  struct Groups {
    std::vector<float> x, y;
    std::vector<std::int32_t> z, at;
    std::vector<std::uint8_t> length, label;
    int count = 0;
    double until = -1, lasts = 0;  // voxels of way
    int room() const { return static_cast<int>(x.size()) - kRoom; }
    Listed listed() { return {x.data(), y.data(), z.data(), at.data(), length.data(), label.data()}; }
    static constexpr int kRoom = 40;  // groups that may be looked at beyond the last

    // Sorted by the pieces of the meridian that can be the closest (of a ball: by where they lie beside it), and by
    // when they may change.
    std::vector<Found> found;
    std::array<Run, kKinds * 2 * kStages> runs;
    int run_count = 0;
    void sort(int listed) noexcept;
    /// To which stage the head has come.
    int stage(double way) const noexcept { return static_cast<int>((way - (until - lasts)) / lasts * kStages); }
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

  /// Which part a layer of blocks belongs to, counted from the front's first.
  int part_of(int layer) const noexcept { return (first_.x + layer) & (parts() - 1); }
  /// Tells the lists which patch they refer to. Lists of another patch stay valid if this one holds all their samples
  /// (`holds`).
  void keep_listed(const glm::ivec3& patch_lo, int n, bool holds) noexcept;
  void drop_listed() noexcept {
    for (Groups& part : parts_) part.until = -1;
  }
  /// How many parts are to be listed anew.
  int outdated() const noexcept;
  /// A part that had better be listed anew now, before it has to be, so that no tick of this way (voxels) need list
  /// several; -1: none.
  int renewed_early(double way) const noexcept;

  /// Table `k` of something that depends on the height of a sample alone.
  float* heights(int k) noexcept { return heights_.data() + k * (size_.z * kDeep + kBeyond); }

  static constexpr int kBeyond = 32;  // samples of a group that begins at the front's last one, and more
  int lanes_;
  glm::ivec3 size_{0};              // blocks
  glm::ivec3 first_{0};             // block at the beginning of due_
  std::vector<float> due_, moved_;  // way at which a block may change; the same while they are shifted
  static constexpr int kMostParts = 16;
  std::vector<Groups> parts_;  // a power of two; positions count from the first voxel of the front's first block
  glm::ivec3 listed_lo_{0};    // of the patch they lie in, and its edge
  int listed_n_ = 0;
  std::vector<float> heights_;
  bool known_ = false;
  double way_ = 0;  // voxels so far
  Pose X_V_;        // where the head is, voxels
};

}  // namespace typodont::haptics
