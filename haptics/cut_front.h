// The active front (docs/cutting.md): states which samples of a patch (a dense copy of the tissue around the tool) the
// next cuts can change. Each sample has a slack: a lower bound of how far the head must still move before it can change
// the sample. The slacks determine for each block of samples the path length at which the block must be examined again.
// Most cuts examine only the samples just ahead of the head. These samples are stored in lists, which are valid for the
// next voxel of the head's path. The lists are divided into parts, which are renewed one after the other.
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

/// The active front of one tool: the samples of a patch (copy of the tissue around the tool) that the tool's next cuts
/// can change. The front stays valid when a newer patch replaces the patch. Blocks are 4 × 4 × 8 voxels, z fastest.
/// Buffers are allocated once, at set-up.
class CutFront {
 public:
  /// Allocates buffers that are large enough for each of these tools. `voxel`: m, voxel size. `lanes`: number of
  /// samples in a group (8 or 16 samples along z that one vector instruction processes); the results of cuts do not
  /// depend on it.
  CutFront(std::span<const Tool> tools, double voxel, int lanes = widest_group());

  /// Returns the number n of parts into which the lists of samples are divided. Part i contains every n-th layer of
  /// blocks of samples along x, starting at layer i. A larger head has more parts, so that each part is small enough to
  /// be renewed within one tick.
  int parts() const noexcept { return static_cast<int>(parts_.size()); }

  /// Consecutive groups (8 or 16 samples along z) of a list with equal properties. `kind`: which pieces of the head's
  /// outline can be nearest to the samples. `narrow`: true if only the first kNarrowest samples of each group can
  /// change. `from`, `to`: indices of the first group and behind the last group.
  /// `stage`: a list is valid while the head moves a given path length, which is divided into kStages equal stages. No
  /// sample of the run can change before the head reaches this stage. For heads that are not balls, `stage` is 0.
  struct Run {
    int kind;
    bool narrow;
    int stage, from, to;
  };
  static constexpr int kStages = 8, kNarrowest = 8;

  /// A group of samples in the unsorted list `Groups::found`, which a search has filled. Groups::sort() then sorts the
  /// groups by kind and stage, so that groups of the same kind can be processed together (see Run).
  struct Found {
    float x, y;
    std::int32_t z, at;
    int kind, stage;
    bool narrow;
    std::uint8_t length, label;
  };

  /// The sorted groups (8 or 16 samples along z) of a list, with one array per property. A vector load may read a few
  /// elements beyond the last group.
  struct Listed {
    float* x;  // voxels, for each group: x coordinate of its samples relative to the first voxel of the active front
    float* y;
    std::int32_t* z;
    std::int32_t* at;      // array index of the group's first sample, relative to the first voxel of the active front
    std::uint8_t* length;  // for each group: number of samples that may change
    std::uint8_t* label;   // for each group: tissue of the samples that may change
  };

  /// Must be called after a filling or an undo, and after cuts by another tool. After these changes, the stored slacks
  /// (distances that the head must move before a sample can change) are not valid.
  void forget() noexcept { known_ = false; }
  /// The first sample of a listed group (8 or 16 samples along z), as an index in a patch (copy of the tissue around
  /// the tool). The patch has the edge length n (samples) and begins at the voxel `patch_lo`. `lanes`: number of
  /// samples in the group.
  struct Place {
    std::ptrdiff_t at;
    int lanes;
  };
  std::vector<Place> listed_in(const glm::ivec3& patch_lo, int n) const;
  /// Must be called when only tissue labels have changed. The lists, which contain the labels, are then made again.
  void renew_lists() noexcept { drop_listed(); }
  /// Returns the number of parts without a valid list. They are cut without a list, which takes longer.
  int outdated() const noexcept;

 private:
  friend class Sweep;

  static constexpr int kRows = 4, kDeep = 8;
  // voxels; at this value, the path length restarts at 0, because a float would lose precision
  static constexpr double kRound = 512;
  static constexpr float kNever = 1e9f;
  // Largest number of kinds of groups. The kind of a group (8 or 16 samples along z) states which pieces of the head's
  // outline can be nearest to it.
  static constexpr int kKinds = 20;
  // voxels, path length of the head for which a list is valid. kListedOfBall: for heads that are balls; kListedOfHead:
  // for other heads. With a larger value, lists are renewed less often but are longer.
  static constexpr double kListedOfBall = 1, kListedOfHead = 0.75;
  // Voxels, longest motion in one sweep for which lists are used. A faster head would soon reach the end of the path
  // length for which a list is valid.
  static constexpr double kMostListed = 0.2;

  /// One part of the lists. It contains the groups (8 or 16 samples along z) that the head may change until its path
  /// length is `until`. The arrays contain for each group the position and the array index of its first sample (both
  /// relative to the first voxel of the active front), the number of samples that may change, and their tissue.
  struct Groups {
    std::vector<float> x, y;
    std::vector<std::int32_t> z, at;
    std::vector<std::uint8_t> length, label;
    int count = 0;
    // voxels; until: path length of the head at which the list expires; lasts: length of the path for which the list
    // was valid when it was made
    double until = -1, lasts = 0;
    int room() const { return static_cast<int>(x.size()) - kRoom; }
    Listed listed() { return {x.data(), y.data(), z.data(), at.data(), length.data(), label.data()}; }
    // number of unused elements at the end of the arrays; they are needed because a vector load may read beyond the
    // last group of samples
    static constexpr int kRoom = 40;

    // The groups of samples before sorting. sort() sorts them by kind and stage. The kind of a group states which
    // pieces of the meridian (outline of the head) can be nearest to the group; for a ball, it states where the group
    // is relative to the ball.
    std::vector<Found> found;
    std::array<Run, kKinds * 2 * kStages> runs;
    int run_count = 0;
    void sort(int listed) noexcept;
    /// Makes a list of the `listed` groups in `found`. The list is valid from the path length `way` on, for `valid_for`
    /// (voxels). If `found` was too small for all groups, the part stays without a list.
    void renew(int listed, double way, double valid_for) noexcept;
    /// Returns the stage that the head has reached at the path length `way` (voxels). A stage is an eighth of the path
    /// length for which the list is valid.
    int stage(double way) const noexcept { return static_cast<int>((way - (until - lasts)) / lasts * kStages); }
  };

  /// Must be called before each sweep. While a drill moves along its axis, the lists contain no samples beside the
  /// drill's flank. If the next sweep has another direction, such lists are dropped.
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

  /// The lists of samples are divided into parts. Returns the index of the part that contains the blocks of layer
  /// `layer`; layers are counted from the first layer of the active front.
  int part_of(int layer) const noexcept { return (first_.x + layer) & (parts() - 1); }
  /// The blocks of samples from `first` to `last` (inclusive), counted from the first block of the active front.
  struct Blocks {
    glm::ivec3 first, last;
  };
  /// Returns the blocks in which a cut, or the next voxel of the head's path after it, can change samples. `lo`, `hi`:
  /// box of the cut's sweep, voxels.
  Blocks reached(const glm::ivec3& lo, const glm::ivec3& hi) const noexcept {
    const glm::ivec3 step(kRows, kRows, kDeep), origin = first_ * step;
    return {(lo - 1 - origin) / step, (hi + 1 - origin) / step};
  }
  /// Returns the path length of the head at the start of a cut, in voxels. `travel`: path length of the cut.
  float way_before(double travel) const noexcept { return static_cast<float>(way_ - travel); }
  /// Decides which parts get new lists in one cut, and for which path length these lists are valid. A cut makes at most
  /// one list for every eight parts that the head reaches, but at least one. Without this limit, the first cut in new
  /// tissue would make all lists, and its tick would take five times as long as the median. The other outdated parts
  /// are cut without a list, and get their lists in the next cuts. A head can reach fewer layers of blocks than the
  /// front has parts, because the front is large enough for every tool and every direction. The lists of the parts that
  /// it does not reach are empty, and are not counted.
  class Renewal {
   public:
    /// `travel`: voxels, path length of the head in this cut; `listed`: kListedOfBall or kListedOfHead.
    Renewal(const CutFront& front, const Blocks& reached, double travel, double listed) noexcept;
    /// Returns true if this cut uses the present list of the part.
    bool keeps(int part) const noexcept {
      return front_.way_ <= front_.parts_[static_cast<std::size_t>(part)].until && part != early_;
    }
    /// Call this function once for each part whose list is not kept. Returns the path length in voxels for which the
    /// new list of the part is valid; 0: the part gets no list in this cut.
    double lasts(int part) noexcept;

   private:
    const CutFront& front_;
    int first_part_, layers_;  // part of the first layer that the head reaches; number of these layers
    int most_;                 // largest number of lists of reached parts that this cut makes
    // Voxels. The lists of one cut are valid for one, two, ... times this path length, so that they expire in different
    // cuts. `ahead_`: for the reached parts; `ahead_of_empty_`: for the others.
    double ahead_, ahead_of_empty_;
    int early_;  // part that gets a new list although its list is still valid; -1: none
    int made_ = 0, empty_ = 0;
  };
  /// Sets the patch (copy of the tissue) to which the lists of samples refer. `holds`: true if the new patch contains
  /// all samples of the existing lists, which then stay valid. `n`: edge length of the patch in samples.
  void keep_listed(const glm::ivec3& patch_lo, int n, bool holds) noexcept;
  void drop_listed() noexcept {
    for (Groups& part : parts_) part.until = -1;
  }
  /// Returns the part of the lists that should be renewed in this tick although it has not expired; otherwise several
  /// parts would expire in one later tick. Returns -1 if no part needs this. `way`: path length of the head per tick,
  /// voxels.
  int renewed_early(double way) const noexcept;

  /// Returns the table with the index `k`. The tables contain the terms of the distance from the head that depend only
  /// on a sample's z coordinate.
  float* heights(int k) noexcept { return heights_.data() + k * (size_.z * kDeep + kBeyond); }

  // Number of additional entries at the end of each table of z-dependent terms. They are needed because a group (8 or
  // 16 samples along z) may begin at the last sample of the active front and extend beyond it.
  static constexpr int kBeyond = 32;
  int lanes_;
  glm::ivec3 size_{0};   // size of the active front in blocks of samples
  glm::ivec3 first_{0};  // position of the first block of the active front in the grid of blocks
  // due_: for each block of samples, the path length at which the block must be examined again; moved_: buffer that is
  // used when the active front moves
  std::vector<float> due_, moved_;
  static constexpr int kMostParts = 16;
  // The lists of samples, divided into parts; the number of parts is a power of two. Positions of samples are relative
  // to the first voxel of the active front.
  std::vector<Groups> parts_;
  // First voxel of the patch (copy of the tissue) to which the lists refer. `listed_n_`: edge length of this patch in
  // voxels.
  glm::ivec3 listed_lo_{0};
  int listed_n_ = 0;
  std::vector<float> heights_;
  bool known_ = false;
  bool along_axis_ = false;  // true if the last sweep was a motion of a drill along its axis
  double way_ = 0;           // voxels, path length of the head's farthest point since the count was last set to 0
  Pose X_V_;                 // pose of the head in the frame V of the voxel grid, in voxels
};

}  // namespace typodont::haptics
