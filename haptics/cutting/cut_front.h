// The active front (docs/cutting.md) tells which samples the next cuts can change. Safe travel of a sample: distance
// that the head can surely move before the sample changes. A block must be examined again when the safe travel of one
// of its samples is used up. Lists contain the samples just ahead of the head.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Number of samples along z in a group: 8 or 16, as many as one vector instruction of this processor handles. 0: on
/// this processor, a cut uses no lists.
int widest_group() noexcept;

/// The active front of one tool: stores which samples its cuts can change. Remains valid when the tissue patch is
/// replaced. Blocks: 4 × 4 × 8 voxels, z is the fastest index. Allocates at set-up only.
class CutFront {
 public:
  /// Allocates buffers for all tools in `tools`. `voxel`: m. `lanes`: 8 or 16, at most widest_group(); results do
  /// not depend on it.
  CutFront(std::span<const Tool> tools, double voxel, int lanes = widest_group());

  /// Number n of parts. Part i contains every n-th layer of blocks along x, from layer i on. Larger heads have more
  /// parts, so that the list of one part is short enough to be made again in one tick.
  int parts() const noexcept { return static_cast<int>(parts_.size()); }

  /// The groups `from` to `to` - 1 of a sorted list have equal values of kind, narrow and stage. `kind`: which pieces
  /// of the meridian can be nearest to the samples. `narrow`: only the first kNarrowest samples of a group can change.
  /// `stage`: the list's lifetime has eight stages, 0 to 7; the samples cannot change before this stage.
  struct Run {
    int kind;
    bool narrow;
    int stage, from, to;
  };
  static constexpr int kStages = 8, kNarrowest = 8;

  /// A group of samples in the unsorted list `Groups::found`. Groups::sort() sorts the list by Found::kind and stage.
  struct Found {
    float x, y;
    std::int32_t z, at;
    int kind, stage;
    bool narrow;
    std::uint8_t length, label;
  };

  /// The sorted list of groups, one array per property. Vector loads may read beyond the last element.
  struct Listed {
    float* x;  // voxels, x of each group relative to the first voxel of CutFront
    float* y;
    std::int32_t* z;
    std::int32_t* at;      // index of the first sample, relative to the first voxel of CutFront
    std::uint8_t* length;  // how many samples of the group may change
    std::uint8_t* label;   // tissue of the samples that may change
  };

  /// Call it after a filling, an undo or cuts by another tool: samples may then change earlier than is stored here.
  void forget() noexcept { known_ = false; }
  /// Call it if only labels have changed, because the lists contain labels.
  void renew_lists() noexcept { drop_listed(); }
  /// Number of parts without a valid list. Such parts are cut without a list, which takes longer.
  int outdated() const noexcept;

 private:
  friend class Sweep;

  static constexpr int kRows = 4, kRowLength = 8;
  // voxels; when the path length exceeds this, it is reset, so that floats remain precise
  static constexpr double kRound = 512;
  static constexpr float kNever = 1e9f;
  // number of different values of Run::kind
  static constexpr int kKinds = 20;
  // Voxels of path for which a list is valid: for balls, and for other heads. Lists with a longer validity are renewed
  // less often, but contain more groups.
  static constexpr double kListedOfBall = 1, kListedOfHead = 0.75;
  // Voxels per tick. Faster heads get no lists, because they would use up a list within a few ticks.
  static constexpr double kMaxListed = 0.2;

  /// The list of one part: groups of samples that the head may change before its path length is `until`. Arrays, for
  /// each group: position and index of its first sample, relative to the first stored voxel; number of samples that may
  /// change; their tissue.
  struct Groups {
    std::vector<float> x, y;
    std::vector<std::int32_t> z, at;
    std::vector<std::uint8_t> length, label;
    int count = 0;
    // voxels; until: path length at which the list expires; lasts: motion for which a new list is valid
    double until = -1, lasts = 0;
    int capacity() const { return static_cast<int>(x.size()) - kPadding; }
    Listed listed() { return {x.data(), y.data(), z.data(), at.data(), length.data(), label.data()}; }
    // spare elements for vector loads beyond the last group
    static constexpr int kPadding = 40;

    // The groups before they are sorted by kind and stage (Run). If the head is a ball, a group's kind is its position:
    // ahead of, beside or behind the ball.
    std::vector<Found> found;
    std::array<Run, kKinds * 2 * kStages> runs;
    int run_count = 0;
    void sort(int listed) noexcept;
    /// Lists the first `listed` groups of samples in `found`. From the path length `path_length` on, the list is valid
    /// for a motion of `valid_for` voxels. If `found` was too small, this part of the front gets no list.
    void renew(int listed, double path_length, double valid_for) noexcept;
    /// Stage at the path length `path_length` (voxels); each stage is an eighth of the list's lifetime.
    int stage(double path_length) const noexcept {
      return static_cast<int>((path_length - (until - lasts)) / lasts * kStages);
    }
  };

  /// Call it before each sweep. While a drill moves along its axis, its lists lack the samples beside the flank. So the
  /// lists are dropped when the motion leaves the axis.
  void begin_sweep(bool along_axis) noexcept {
    if (along_axis_ && !along_axis) drop_listed();
    along_axis_ = along_axis;
  }
  /// Returns true if the stored box of blocks contains all blocks around the voxels lo to hi.
  bool holds(const glm::ivec3& lo, const glm::ivec3& hi) const noexcept;
  /// Sets the head's pose `X_V` (voxels), and adds `travel` (voxels), the motion of the head's farthest point, to the
  /// path length.
  void advance_to(const Pose& X_V, double travel) noexcept;
  /// Moves the stored box of blocks so that it contains all blocks around the voxels lo to hi.
  void move_around(const glm::ivec3& lo, const glm::ivec3& hi) noexcept;
  float* due(const glm::ivec3& block) noexcept {
    const glm::ivec3 at = block - first_;
    return due_.data() + (at.x * size_.y + at.y) * size_.z + at.z;
  }

  /// Part to which a layer of blocks along x belongs. `layer`: counted from the first stored layer.
  int part_of(int layer) const noexcept { return (first_.x + layer) & (parts() - 1); }
  /// Box of blocks, both ends inclusive; indices are relative to the first stored block.
  struct Blocks {
    glm::ivec3 first, last;
  };
  /// Blocks that can change in this cut or in the next voxel of motion. `lo`, `hi`: box of the sweep, voxels.
  Blocks reached(const glm::ivec3& lo, const glm::ivec3& hi) const noexcept {
    const glm::ivec3 step(kRows, kRows, kRowLength), origin = first_ * step;
    return {(lo - 1 - origin) / step, (hi + 1 - origin) / step};
  }
  /// Path length (voxels) before a cut of length `travel`.
  float path_length_before(double travel) const noexcept { return static_cast<float>(path_length_ - travel); }
  /// Decides which parts get new lists in a cut. Of the parts that the head reaches, at least one and at most an eighth
  /// get lists, so that the first cut in new tissue is fast. Parts that it does not reach get empty lists.
  class Renewal {
   public:
    /// `travel`: length of the cut, voxels; `listed`: path length for which a list is valid, voxels.
    Renewal(const CutFront& front, const Blocks& reached, double travel, double listed) noexcept;
    /// Returns true if this cut keeps the part's list.
    bool keeps(int part) const noexcept {
      return front_.path_length_ <= front_.parts_[static_cast<std::size_t>(part)].until && part != early_;
    }
    /// Path of the head in voxels for which a new list is valid; 0: no list. Call it once per part without a list.
    double lasts(int part) noexcept;

   private:
    const CutFront& front_;
    int first_part_, layers_;  // part to which the first reached layer of blocks belongs; number of these layers
    int most_;                 // largest number of reached parts that get lists
    // Voxels. The new lists of one cut are valid for 1, 2, … × this length, so that they expire one after another.
    // ahead_: for parts that the head reaches; ahead_of_empty_: for others.
    double ahead_, ahead_of_empty_;
    int early_;  // index of a part that gets a new list although its list is still valid; -1: none
    int made_ = 0, empty_ = 0;
  };
  /// `holds`: the new tissue patch contains all listed samples, so the lists remain valid. `n`: edge of the patch in
  /// samples.
  void keep_listed(const glm::ivec3& patch_lo, int n, bool holds) noexcept;
  void drop_listed() noexcept {
    for (Groups& part : parts_) part.until = -1;
  }
  /// Part that should be renewed now, because several lists would expire in one later tick; -1: none. `travel`: voxels
  /// per tick.
  int renewed_early(double travel) const noexcept;

  /// Table of the parts of a distance that depend only on z. `k`: number of the table.
  float* heights(int k) noexcept { return heights_.data() + k * (size_.z * kRowLength + kBeyond); }

  // Spare elements at the end of each table in heights_: a group may begin at the last sample of the stored blocks.
  static constexpr int kBeyond = 32;
  int lanes_;
  glm::ivec3 size_{0};   // number of stored blocks along each axis
  glm::ivec3 first_{0};  // index of the first stored block
  // due_: path length at which each block must be examined; moved_: buffer for move_around()
  std::vector<float> due_, moved_;
  static constexpr int kMaxParts = 16;
  // One list per part; the number of parts is a power of two. Positions are relative to the first stored voxel.
  std::vector<Groups> parts_;
  // First voxel and edge (samples) of the tissue patch for which the lists were made.
  glm::ivec3 listed_lo_{0};
  int listed_n_ = 0;
  std::vector<float> heights_;
  bool known_ = false;
  bool along_axis_ = false;  // true: the last sweep moved a drill along its axis
  double path_length_ = 0;   // voxels, path length of the head's farthest point since the last reset
  Pose X_V_;                 // pose of the head in frame V, voxels
};

}  // namespace typodont::haptics
