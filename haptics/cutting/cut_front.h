// The active front (docs/cutting.md): which samples of a patch the next cuts can change. Each has a slack, a lower
// bound of the head's way until it can change; from these, each block has the path length at which it must be examined
// again. Samples just ahead are in lists, valid for the next voxel of path, in parts that are renewed in turn.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// 8 or 16 samples along z per vector instruction.
int widest_group() noexcept;

/// Of one tool; stays valid when the patch is replaced. Blocks: 4 × 4 × 8 voxels, z fastest. Allocates at set-up only.
class CutFront {
 public:
  /// Buffers for each of these tools. `voxel`: m. `lanes`: 8 or 16; results do not depend on it.
  CutFront(std::span<const Tool> tools, double voxel, int lanes = widest_group());

  /// n: part i has every n-th layer of blocks along x from i. Larger heads have more, each small enough for one tick.
  int parts() const noexcept { return static_cast<int>(parts_.size()); }

  /// Consecutive groups with equal properties. `kind`: pieces of the outline that can be nearest. `narrow`: only the
  /// first kNarrowest samples can change. `from`, `to`: groups. `stage`: of kStages equal ones of the list's path
  /// length, before which nothing changes; 0 if no ball.
  struct Run {
    int kind;
    bool narrow;
    int stage, from, to;
  };
  static constexpr int kStages = 8, kNarrowest = 8;

  /// Of the unsorted list `Groups::found`; Groups::sort() orders by kind and stage (Run).
  struct Found {
    float x, y;
    std::int32_t z, at;
    int kind, stage;
    bool narrow;
    std::uint8_t length, label;
  };

  /// Sorted, one array per property. A vector load may read beyond the last.
  struct Listed {
    float* x;  // voxels, x per group from the front's first voxel
    float* y;
    std::int32_t* z;
    std::int32_t* at;      // array index of the first sample, from the front's first voxel
    std::uint8_t* length;  // samples that may change, per group
    std::uint8_t* label;   // their tissue
  };

  /// After a filling, an undo, or cuts by another tool: slacks are then invalid.
  void forget() noexcept { known_ = false; }
  /// First sample of a group, in a patch of edge n from voxel `patch_lo`.
  struct Place {
    std::ptrdiff_t at;
    int lanes;
  };
  std::vector<Place> listed_in(const glm::ivec3& patch_lo, int n) const;
  /// When only labels have changed: the lists hold them.
  void renew_lists() noexcept { drop_listed(); }
  /// Cut without a list, which takes longer.
  int outdated() const noexcept;

 private:
  friend class Sweep;

  static constexpr int kRows = 4, kDeep = 8;
  // voxels, at which the path length restarts before a float loses precision
  static constexpr double kRound = 512;
  static constexpr float kNever = 1e9f;
  // Which pieces of the outline can be nearest.
  static constexpr int kKinds = 20;
  // voxels of path for which a list is valid: balls, other heads. More: renewed less often, but longer.
  static constexpr double kListedOfBall = 1, kListedOfHead = 0.75;
  // Voxels; faster heads would soon reach the list's end.
  static constexpr double kMostListed = 0.2;

  /// One part of the lists. It contains the groups (8 or 16 samples along z) that the head may change until its path
  /// length is `until`. The arrays contain for each group the position and the array index of its first sample (both
  /// relative to the first voxel of the active front), the number of samples that may change, and their tissue.
  struct Groups {
    std::vector<float> x, y;
    std::vector<std::int32_t> z, at;
    std::vector<std::uint8_t> length, label;
    int count = 0;
    // voxels: path length at expiry, and validity when made
    double until = -1, lasts = 0;
    int room() const { return static_cast<int>(x.size()) - kRoom; }
    Listed listed() { return {x.data(), y.data(), z.data(), at.data(), length.data(), label.data()}; }
    // for vector loads beyond the last group
    static constexpr int kRoom = 40;

    // Before sorting by kind and stage. Kind: pieces of the meridian that can be nearest; for a ball, where the group
    // is.
    std::vector<Found> found;
    std::array<Run, kKinds * 2 * kStages> runs;
    int run_count = 0;
    void sort(int listed) noexcept;
    /// Of the `listed` groups in `found`, valid from path `way` for `valid_for` (voxels). If `found` was too small, the
    /// part stays without.
    void renew(int listed, double way, double valid_for) noexcept;
    /// At path `way` (voxels); an eighth of the validity each.
    int stage(double way) const noexcept { return static_cast<int>((way - (until - lasts)) / lasts * kStages); }
  };

  /// Before each sweep. A drill along its axis lists nothing beside its flank; such lists are dropped when it leaves
  /// that direction.
  void begin_sweep(bool along_axis) noexcept {
    if (along_axis_ && !along_axis) drop_listed();
    along_axis_ = along_axis;
  }
  /// Room for all blocks around the voxels lo to hi.
  bool holds(const glm::ivec3& lo, const glm::ivec3& hi) const noexcept;
  /// `X_V`: voxels. `way`: of the farthest point, voxels, added to the path.
  void advance_to(const Pose& X_V, double way) noexcept;
  /// So that it contains all blocks around lo to hi.
  void move_around(const glm::ivec3& lo, const glm::ivec3& hi) noexcept;
  float* due(const glm::ivec3& block) noexcept {
    const glm::ivec3 at = block - first_;
    return due_.data() + (at.x * size_.y + at.y) * size_.z + at.z;
  }

  /// Of the blocks in `layer`, counted from the front's first.
  int part_of(int layer) const noexcept { return (first_.x + layer) & (parts() - 1); }
  /// Inclusive, from the front's first.
  struct Blocks {
    glm::ivec3 first, last;
  };
  /// That this cut, or the next voxel of path, can change. `lo`, `hi`: the sweep's box, voxels.
  Blocks reached(const glm::ivec3& lo, const glm::ivec3& hi) const noexcept {
    const glm::ivec3 step(kRows, kRows, kDeep), origin = first_ * step;
    return {(lo - 1 - origin) / step, (hi + 1 - origin) / step};
  }
  /// Voxels, at the start of a cut of length `travel`.
  float way_before(double travel) const noexcept { return static_cast<float>(way_ - travel); }
  /// Which parts get lists in a cut, and for how long: at least one, at most one per eight reached parts. Otherwise the
  /// first cut in new tissue would make all, in a tick of five times the median; the rest is cut without and follows.
  /// Unreached parts have empty lists, which do not count: the front is large enough for every tool and direction.
  class Renewal {
   public:
    /// `travel`: voxels; `listed`: kListedOfBall or kListedOfHead.
    Renewal(const CutFront& front, const Blocks& reached, double travel, double listed) noexcept;
    /// By this cut.
    bool keeps(int part) const noexcept {
      return front_.way_ <= front_.parts_[static_cast<std::size_t>(part)].until && part != early_;
    }
    /// Once per part whose list is not kept. Voxels of validity; 0: no list in this cut.
    double lasts(int part) noexcept;

   private:
    const CutFront& front_;
    int first_part_, layers_;  // first layer that the head reaches, and their number
    int most_;                 // of reached parts, in this cut
    // Voxels. One cut's lists are valid for one, two, … times this, to expire apart: reached parts, and others.
    double ahead_, ahead_of_empty_;
    int early_;  // renewed although still valid; -1: none
    int made_ = 0, empty_ = 0;
  };
  /// `holds`: the new patch has all listed samples, so lists stay. `n`: its edge, samples.
  void keep_listed(const glm::ivec3& patch_lo, int n, bool holds) noexcept;
  void drop_listed() noexcept {
    for (Groups& part : parts_) part.until = -1;
  }
  /// To be renewed now, or several would expire in one later tick; -1: none. `way`: voxels per tick.
  int renewed_early(double way) const noexcept;

  /// Terms of the distance that depend on z only.
  float* heights(int k) noexcept { return heights_.data() + k * (size_.z * kDeep + kBeyond); }

  // Spare entries per table: a group may begin at the front's last sample.
  static constexpr int kBeyond = 32;
  int lanes_;
  glm::ivec3 size_{0};   // in blocks
  glm::ivec3 first_{0};  // of its first block
  // path length at which each block must be examined; and a buffer for moves
  std::vector<float> due_, moved_;
  static constexpr int kMostParts = 16;
  // A power of two of parts. Positions from the front's first voxel.
  std::vector<Groups> parts_;
  // Of the lists' patch, with its edge in voxels.
  glm::ivec3 listed_lo_{0};
  int listed_n_ = 0;
  std::vector<float> heights_;
  bool known_ = false;
  bool along_axis_ = false;  // the last sweep was a drill's along its axis
  double way_ = 0;           // voxels, of the farthest point since the last reset
  Pose X_V_;                 // of the head in V, voxels
};

}  // namespace typodont::haptics
