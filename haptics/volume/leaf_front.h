// CutFront for the carver: a leaf whose samples cannot change before `slack` voxels of the head's way is skipped until
// then. Private to haptics/volume.
#pragma once

#include <openvdb/openvdb.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "haptics/sweep.h"
#include "haptics/volume/leaf_history.h"

namespace typodont::haptics {

/// Of one head. Carver thread. Keys in leaves of 8³.
class LeafFront {
 public:
  using Leaf = openvdb::FloatTree::LeafNodeType;
  using Kept = LeafHistory<openvdb::FloatTree>::Kept;

  static constexpr float kNow = -1e9f, kNever = 1e9f;

  /// One cache line per place.
  struct alignas(64) Place {
    Leaf* leaf = nullptr;      // null: not examined yet
    float* samples = nullptr;  // here, because the leaf's memory must be waited for
    Kept* kept = nullptr;      // for undo of the present stroke; null: no stroke
    bool cut = false;          // since first examined
    std::uint64_t logged = 0;  // mark after which it was last logged
    // voxels of path, per block
    std::array<float, Sweep::Leaf::kBlocks> due = {kNow, kNow, kNow, kNow};
  };

  /// To examine now. `key`: in leaves. `due`: voxels of path, least of its blocks; apart, because most leaves need
  /// nothing else.
  struct DuePlace {
    glm::ivec3 key;
    Place* place;
    float* due;
  };

  /// After any change but the cuts of one stroke, or a replaced leaf.
  void forget() noexcept { last_.reset(); }

  /// To the end of `sweep`, over leaves lo..hi inclusive.
  void advance_to(const Sweep& sweep, const glm::ivec3& lo, const glm::ivec3& hi);
  /// Voxels, of the farthest point.
  float path() const noexcept { return static_cast<float>(path_); }
  /// Of lo..hi inclusive, by key; within the last advance_to(). Until the next call.
  std::span<const DuePlace> due(const glm::ivec3& lo, const glm::ivec3& hi);

 private:
  // leaves around the sweep, so that the box seldom moves
  static constexpr int kRoom = 2;
  // voxels, at which a float would resolve 6e-5; restarts at 0
  static constexpr double kLongest = 512;

  // for vector loads beyond the last row
  static constexpr int kUnused = 8;

  void move_window(const glm::ivec3& lo, const glm::ivec3& hi);

  std::optional<Sweep> last_;  // empty: position unknown
  double path_ = 0;            // voxels, of the farthest point
  glm::ivec3 first_{0}, size_{0};
  std::vector<float> due_, due_moved_;  // with kUnused unused elements at the end
  std::vector<std::int32_t> found_;     // found by due() in one row
  std::vector<DuePlace> due_places_;
  std::vector<Place> places_, moved_;
};

}  // namespace typodont::haptics
