// The active front of the carver: a leaf whose samples cannot change before the head has moved by `safe_travel` voxels
// is skipped until then. Private to haptics/volume.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "haptics/sweep.h"
#include "haptics/volume/leaf_history.h"

namespace typodont::haptics {

/// The active front of one head. Carver thread only. A leaf has 8³ samples; its key is its position in leaves.
class LeafFront {
 public:
  using Leaf = DistanceGrid::Leaf;
  using Kept = LeafHistory<float>::Kept;

  static constexpr float kNow = -1e9f, kNever = 1e9f;

  /// Data of a leaf in one cache line.
  struct alignas(64) Place {
    Leaf* leaf = nullptr;      // null: the leaf has not been examined yet
    Kept* kept = nullptr;      // copy for undo in the current stroke; null: no stroke
    bool cut = false;          // true: the leaf was cut since it was first examined
    std::uint64_t logged = 0;  // value of TissueVolume::mark() for which the leaf is listed as changed already
    // for each block: path length (voxels) at which the block must be examined again
    std::array<float, Sweep::Leaf::kBlocks> due = {kNow, kNow, kNow, kNow};
  };

  /// A leaf to examine now. `key`: position in leaves. `due`: smallest path length (voxels) of its blocks, stored
  /// separately, because most leaves need nothing else.
  struct DuePlace {
    glm::ivec3 key;
    Place* place;
    float* due;
  };

  /// Forgets the last sweep. Call it when a leaf is replaced, and for every change except cuts of the current stroke.
  void forget() noexcept { last_.reset(); }

  /// Updates path length and head position after `sweep`, and moves the stored box so that it contains leaves lo to hi.
  void advance_to(const Sweep& sweep, const glm::ivec3& lo, const glm::ivec3& hi);
  /// Upper bound of the path length of every point of the head since the last restart at 0, voxels.
  float path() const noexcept { return static_cast<float>(path_); }
  /// Returns the leaves from lo to hi (inclusive) that must be examined now, sorted by key. The range must lie inside
  /// the range of the last advance_to(). Valid until the next call.
  std::span<const DuePlace> due(const glm::ivec3& lo, const glm::ivec3& hi);

 private:
  // leaves that are added on each side of the sweep's box, so that the stored box moves seldom
  static constexpr int kBorder = 2;
  // voxels; at this path length a float resolves 6e-5, so the path restarts at 0
  static constexpr double kLongest = 512;

  // spare elements for vector loads beyond the last row
  static constexpr int kUnused = 8;

  void move_window(const glm::ivec3& lo, const glm::ivec3& hi);

  std::optional<Sweep> last_;  // last sweep of the head; empty: the head's position is not known
  double path_ = 0;            // voxels, see path()
  glm::ivec3 first_{0}, size_{0};
  std::vector<float> due_, due_moved_;  // due path length of each leaf; buffer; both end with kUnused unused elements
  std::vector<std::int32_t> found_;     // indices of the leaves that due() found in one row
  std::vector<DuePlace> due_places_;
  std::vector<Place> places_, moved_;
};

}  // namespace typodont::haptics
