// Finds which samples of a patch the next cuts can change. A sample whose value is `slack` voxels above its depth in
// the head cannot change before the head has moved that far. So each block of voxels stores the path length at which
// the block must be examined again. Most cuts examine only the samples just ahead of the head: lists contain these
// samples for the next voxel of path. The lists are divided into parts, and the parts are computed anew in turn.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Number of samples along z that this processor handles at once: 8 or 16.
int widest_group() noexcept;

/// Active front of one tool, in one patch and its successors. Blocks are 4 × 4 × 8 voxels; z runs fastest. Buffers are
/// allocated once, at set-up.
class CutFront {
 public:
  /// The buffers suffice for each of these tools. `lanes`: samples per group; the result does not depend on it.
  CutFront(std::span<const Tool> tools, double voxel, int lanes = widest_group());

  /// Number of parts of the lists. Part i contains every n-th layer of blocks along x. A larger head has more parts, so
  /// that renewing a part does not make a tick much longer.
  int parts() const noexcept { return static_cast<int>(parts_.size()); }

  /// Consecutive groups of the same kind. `narrow`: only the first kNarrowest samples of each group can change. None of
  /// the groups changes before the head has moved `stage` eighths of the list's lifetime (always 0 for heads that are
  /// not balls).
  struct Run {
    int kind;
    bool narrow;
    int stage, from, to;
  };
  static constexpr int kStages = 8, kNarrowest = 8;

  /// One group, before sorting.
  struct Found {
    float x, y;
    std::int32_t z, at;
    int kind, stage;
    bool narrow;
    std::uint8_t length, label;
  };

  /// Sorted groups as arrays, one array per property. A reader may read a few elements beyond the last group.
  struct Listed {
    float* x;  // voxels, x coordinate from the origin of the groups
    float* y;
    std::int32_t* z;
    std::int32_t* at;      // array index of the sample, relative to the sample at the groups' origin
    std::uint8_t* length;  // number of samples that may change
    std::uint8_t* label;   // tissue of the samples that may change
  };

  /// Call this when anything other than this tool's cuts lowered the field: fillings, undo, another tool.
  void forget() noexcept { known_ = false; }
  /// The first sample of a listed group, as an index in a patch of edge n whose first voxel is `patch_lo`, and the
  /// number of lanes of the group.
  struct Place {
    std::ptrdiff_t at;
    int lanes;
  };
  std::vector<Place> listed_in(const glm::ivec3& patch_lo, int n) const;
  /// Call this when only labels changed. The lists are then computed anew.
  void renew_lists() noexcept { drop_listed(); }

 private:
  friend class Sweep;

  static constexpr int kRows = 4, kDeep = 8;
  static constexpr double kRound =
      512;  // voxels, limit of the path length; beyond it, counting restarts at 0, so that floats keep their precision
  static constexpr float kNever = 1e9f;
  static constexpr int kKinds = 20;  // limit of the number of kinds of groups
  // Lifetime of a list, voxels of path, for balls and for other heads. A longer lifetime means fewer renewals, but
  // larger lists.
  static constexpr double kListedOfBall = 1, kListedOfHead = 0.75;
  // voxels per sweep, limit of the head's motion; a faster head would leave its lists at once, so it uses none
  static constexpr double kMostListed = 0.2;

  /// Groups of samples along z that the head may change before its path length is `until`: first sample, index in the
  /// patch, number of samples that may change, and their tissue.
  struct Groups {
    std::vector<float> x, y;
    std::vector<std::int32_t> z, at;
    std::vector<std::uint8_t> length, label;
    int count = 0;
    double until = -1, lasts = 0;  // voxels, path length at the end of the list's lifetime, and length of the lifetime
    int room() const { return static_cast<int>(x.size()) - kRoom; }
    Listed listed() { return {x.data(), y.data(), z.data(), at.data(), length.data(), label.data()}; }
    static constexpr int kRoom = 40;  // number of unused groups at the end, which a vector load may read

    // Groups are sorted by the pieces of the meridian that can be closest (for a ball: by their position relative to
    // it), and by the stage at which they may change.
    std::vector<Found> found;
    std::array<Run, kKinds * 2 * kStages> runs;
    int run_count = 0;
    void sort(int listed) noexcept;
    /// The stage that the head has reached.
    int stage(double way) const noexcept { return static_cast<int>((way - (until - lasts)) / lasts * kStages); }
  };

  /// Begins a sweep. The lists of a drill that moves along its axis lack the samples beside its flank, so other sweeps
  /// cannot use them.
  void begin_sweep(bool along_axis) noexcept {
    if (along_axis_ && !along_axis) drop_listed();
    along_axis_ = along_axis;
  }
  /// Returns true if the front can store all blocks around lo..hi (voxels).
  bool holds(const glm::ivec3& lo, const glm::ivec3& hi) const noexcept;
  /// Moves the head to `X_V` (voxels); `way`: voxels, path length of the head's farthest point.
  void advance_to(const Pose& X_V, double way) noexcept;
  /// Moves the front so that it contains the blocks around lo..hi.
  void move_around(const glm::ivec3& lo, const glm::ivec3& hi) noexcept;
  float* due(const glm::ivec3& block) noexcept {
    const glm::ivec3 at = block - first_;
    return due_.data() + (at.x * size_.y + at.y) * size_.z + at.z;
  }

  /// The part of a layer of blocks; layers count from the first layer of the front.
  int part_of(int layer) const noexcept { return (first_.x + layer) & (parts() - 1); }
  /// Sets the patch of the lists. The lists of the previous patch stay valid if the new patch contains all their
  /// samples (`holds`).
  void keep_listed(const glm::ivec3& patch_lo, int n, bool holds) noexcept;
  void drop_listed() noexcept {
    for (Groups& part : parts_) part.until = -1;
  }
  /// Number of parts that must be renewed.
  int outdated() const noexcept;
  /// A part that should be renewed now, before it expires, so that no tick must renew several parts; -1: none. `way`:
  /// voxels of path per tick.
  int renewed_early(double way) const noexcept;

  /// Table `k` of values that depend only on the height (z) of a sample.
  float* heights(int k) noexcept { return heights_.data() + k * (size_.z * kDeep + kBeyond); }

  // Number of samples beyond the front that the tables also cover, because a group may begin at the front's last
  // sample
  static constexpr int kBeyond = 32;
  int lanes_;
  glm::ivec3 size_{0};              // blocks, size of the front
  glm::ivec3 first_{0};             // key of the first block in due_
  std::vector<float> due_, moved_;  // path length at which a block may change; moved_ is a buffer for shifting due_
  static constexpr int kMostParts = 16;
  std::vector<Groups> parts_;  // number is a power of two; positions are relative to the first voxel of the front
  // Voxel of the first sample of the patch for which the groups are listed; `listed_n_` is its edge in voxels
  glm::ivec3 listed_lo_{0};
  int listed_n_ = 0;
  std::vector<float> heights_;
  bool known_ = false;
  bool along_axis_ = false;  // the last sweep was along the axis of a drill
  double way_ = 0;           // voxels, path length so far
  Pose X_V_;                 // pose of the head in V, in voxels
};

}  // namespace typodont::haptics
