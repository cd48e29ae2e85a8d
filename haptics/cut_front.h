// Determines which samples of a patch (a dense copy of the tissue around the tool) the next cuts can change: the active
// front, docs/cutting.md. Each sample has a slack: a lower bound of how far the head must still move before it can
// change the sample. From the slacks, each block of samples gets the path length at which it must be examined again.
// Most cuts examine only the samples just ahead of the head: lists contain the samples that may change during the next
// voxel of path. The lists are divided into parts, which are renewed one after the other.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Returns the number of samples along z that one vector instruction of this processor handles: 8 or 16.
int widest_group() noexcept;

/// The active front of one tool: the samples of a patch (copy of the tissue around the tool) that its next cuts can
/// change, also in later patches. Blocks are 4 × 4 × 8 voxels, z fastest. Buffers are allocated once, at set-up.
class CutFront {
 public:
  /// Allocates buffers that are large enough for each of these tools. `voxel`: m, voxel size; `lanes`: number of
  /// samples in a group; the result of a cut does not depend on it.
  CutFront(std::span<const Tool> tools, double voxel, int lanes = widest_group());

  /// Returns the number n of parts into which the lists of samples are divided. Part i contains every n-th layer of
  /// blocks of samples along x, starting at layer i. A larger head has more parts, so that each part is small enough to
  /// be renewed within one tick.
  int parts() const noexcept { return static_cast<int>(parts_.size()); }

  /// Consecutive groups of samples in a list that have the same kind. The kind states which pieces of the head's
  /// outline can be nearest to the samples. `narrow`: only the first kNarrowest samples of each group can change.
  /// `stage`: no group changes before the head has moved this number of eighths of the path for which the list is valid
  /// (always 0 for heads that are not balls).
  struct Run {
    int kind;
    bool narrow;
    int stage, from, to;
  };
  static constexpr int kStages = 8, kNarrowest = 8;

  /// A group of samples as the search finds it, in the unsorted list `Groups::found`. Groups::sort() then sorts the
  /// groups by kind and stage, so that groups of the same kind can be processed together (see Run).
  struct Found {
    float x, y;
    std::int32_t z, at;
    int kind, stage;
    bool narrow;
    std::uint8_t length, label;
  };

  /// The sorted groups of a list, with one array per property. A vector load may read a few elements beyond the last
  /// group.
  struct Listed {
    float* x;  // voxels, x coordinate relative to the first voxel of the active front
    float* y;
    std::int32_t* z;
    std::int32_t* at;      // array index of the group's first sample, relative to the first voxel of the active front
    std::uint8_t* length;  // number of samples in the group that may change
    std::uint8_t* label;   // tissue of the samples that may change
  };

  /// Must be called after a filling or an undo, and after cuts by another tool, because the stored slacks (motion until
  /// a sample can change) are then not valid.
  void forget() noexcept { known_ = false; }
  /// The first sample of a listed group, as an index in a patch (copy of the tissue around the tool) with edge length n
  /// whose first voxel is `patch_lo`. `lanes`: number of samples in the group.
  struct Place {
    std::ptrdiff_t at;
    int lanes;
  };
  std::vector<Place> listed_in(const glm::ivec3& patch_lo, int n) const;
  /// Must be called when only tissue labels have changed. The lists, which contain the labels, are then made again.
  void renew_lists() noexcept { drop_listed(); }

 private:
  friend class Sweep;

  static constexpr int kRows = 4, kDeep = 8;
  static constexpr double kRound = 512;  // voxels; at this value the path length restarts at 0, to keep float precision
  static constexpr float kNever = 1e9f;
  static constexpr int kKinds = 20;  // largest number of kinds of groups of samples (see Run)
  // Length of the head's path, in voxels, for which a list is valid. kListedOfBall: for balls; kListedOfHead: for other
  // heads. With a larger value, lists are renewed less often but are longer.
  static constexpr double kListedOfBall = 1, kListedOfHead = 0.75;
  // Voxels, longest motion in one sweep for which lists are used. The path of a faster head would soon be too long for
  // the list.
  static constexpr double kMostListed = 0.2;

  /// One part of the lists: the groups of samples along z that the head may change before its path length is `until`.
  /// The arrays contain the position of the first sample, its index in the patch, the number of samples that may
  /// change, and their tissue.
  struct Groups {
    std::vector<float> x, y;
    std::vector<std::int32_t> z, at;
    std::vector<std::uint8_t> length, label;
    int count = 0;
    // voxels; until: path length at which the list expires; lasts: path length for which the list is valid in
    // total
    double until = -1, lasts = 0;
    int room() const { return static_cast<int>(x.size()) - kRoom; }
    Listed listed() { return {x.data(), y.data(), z.data(), at.data(), length.data(), label.data()}; }
    static constexpr int kRoom = 40;  // number of unused elements at the end, because a vector load may read them

    // The groups of samples before sorting. They are sorted by kind (the pieces of the meridian that can be nearest;
    // for a ball, the position of the group of samples relative to the ball) and by the stage at which they may change.
    std::vector<Found> found;
    std::array<Run, kKinds * 2 * kStages> runs;
    int run_count = 0;
    void sort(int listed) noexcept;
    /// Returns the stage (eighth of the list's lifetime) that the head has reached at the path length `way`.
    int stage(double way) const noexcept { return static_cast<int>((way - (until - lasts)) / lasts * kStages); }
  };

  /// Must be called before each sweep. While a drill moves along its axis, its lists contain no samples beside its
  /// flank. Such lists are dropped before a sweep in another direction.
  void begin_sweep(bool along_axis) noexcept {
    if (along_axis_ && !along_axis) drop_listed();
    along_axis_ = along_axis;
  }
  /// Returns true if the active front is large enough for all blocks of samples around the voxels lo to hi.
  bool holds(const glm::ivec3& lo, const glm::ivec3& hi) const noexcept;
  /// Sets the pose of the head to `X_V` (voxels), and adds `way` to the path length. `way`: displacement of the head's
  /// farthest point, voxels.
  void advance_to(const Pose& X_V, double way) noexcept;
  /// Moves the active front such that it contains all blocks of samples around the voxels lo to hi.
  void move_around(const glm::ivec3& lo, const glm::ivec3& hi) noexcept;
  float* due(const glm::ivec3& block) noexcept {
    const glm::ivec3 at = block - first_;
    return due_.data() + (at.x * size_.y + at.y) * size_.z + at.z;
  }

  /// Returns the index of the part of the lists of samples that contains a layer of blocks; layers are counted from the
  /// first layer of the active front.
  int part_of(int layer) const noexcept { return (first_.x + layer) & (parts() - 1); }
  /// Sets the patch (copy of the tissue) to which the lists of samples refer. The existing lists stay valid if `holds`
  /// is true, that is, if the new patch contains all their samples. `n`: edge length of the patch in samples.
  void keep_listed(const glm::ivec3& patch_lo, int n, bool holds) noexcept;
  void drop_listed() noexcept {
    for (Groups& part : parts_) part.until = -1;
  }
  /// Returns how many parts of the lists (of samples that cuts may change) have expired.
  int outdated() const noexcept;
  /// Returns a part of the lists of samples that should be renewed now, before it expires, so that later no tick must
  /// renew several parts; -1: none. `way`: path of the head per tick, voxels.
  int renewed_early(double way) const noexcept;

  /// Returns table `k` of terms that depend only on the z coordinate of a sample.
  float* heights(int k) noexcept { return heights_.data() + k * (size_.z * kDeep + kBeyond); }

  // Number of additional entries in the tables of z-dependent terms beyond the active front, because a group of samples
  // may begin at the last sample of the front.
  static constexpr int kBeyond = 32;
  int lanes_;
  glm::ivec3 size_{0};   // size of the active front in blocks of samples
  glm::ivec3 first_{0};  // position of the first block of the active front in the grid of blocks
  // due_: for each block of samples, the path length at which it must be examined again; moved_: buffer for moving the
  // active front
  std::vector<float> due_, moved_;
  static constexpr int kMostParts = 16;
  // the parts of the lists of samples; their number is a power of two; positions are relative to the first voxel of the
  // active front
  std::vector<Groups> parts_;
  // First voxel of the patch (copied tissue) to which the lists refer; `listed_n_`: edge length of the patch in voxels.
  glm::ivec3 listed_lo_{0};
  int listed_n_ = 0;
  std::vector<float> heights_;
  bool known_ = false;
  bool along_axis_ = false;  // true if the last sweep was a motion of a drill along its axis
  double way_ = 0;           // voxels, path length of the head's farthest point since the last restart
  Pose X_V_;                 // pose of the head in the frame V of the voxel grid, in voxels
};

}  // namespace typodont::haptics
