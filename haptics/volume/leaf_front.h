// Which leaves of the tissue the next cuts can still change: the carver's counterpart of CutFront. A leaf none of whose
// samples can rise before the head has moved `slack` voxels is skipped for that much of the head's path. Private to
// haptics/volume.
#pragma once

#include <openvdb/openvdb.h>

#include <optional>
#include <vector>

#include "haptics/sweep.h"
#include "haptics/volume/leaf_history.h"

namespace typodont::haptics {

/// Of one head. Carver's thread. Keys count leaves of 8³ samples.
class LeafFront {
 public:
  using Leaf = openvdb::FloatTree::LeafNodeType;
  using Kept = LeafHistory<openvdb::FloatTree>::Kept;

  struct Place {
    Leaf* leaf = nullptr;      // once it has been examined
    Kept* kept = nullptr;      // in the current stroke, if there is one
    bool cut = false;          // since it was first examined
    std::uint64_t logged = 0;  // the last mark in whose log of writes it stands
  };
  static constexpr float kNow = -1e9f, kNever = 1e9f;

  /// To be called when anything but the cuts of one stroke changes the distances, or replaces a leaf.
  void forget() noexcept { last_.reset(); }

  /// The head goes on to the end of `sweep`, which reaches the leaves lo..hi, inclusive.
  void come_to(const Sweep& sweep, const glm::ivec3& lo, const glm::ivec3& hi);
  /// Path length of the head's farthest point by now, voxels.
  float path() const noexcept { return static_cast<float>(path_); }
  /// The leaves of a row from `key` on, along z: after which path length each must be examined again, voxels, and the
  /// rest. Apart, because most leaves are only asked for the first.
  struct Row {
    float* due;
    Place* places;
  };
  Row row(const glm::ivec3& key) noexcept {
    const glm::ivec3 at = key - first_;
    const auto i = static_cast<std::size_t>((at.x * size_.y + at.y) * size_.z + at.z);
    return {due_.data() + i, places_.data() + i};
  }

 private:
  static constexpr int kRoom = 2;          // leaves around what a sweep reaches, so that the window rarely moves
  static constexpr double kLongest = 512;  // voxels of path after which counting starts anew: floats keep 6e-5

  void move_window(const glm::ivec3& lo, const glm::ivec3& hi);

  std::optional<Sweep> last_;  // none: nothing is known
  double path_ = 0;            // voxels
  glm::ivec3 first_{0}, size_{0};
  std::vector<float> due_, due_moved_;
  std::vector<Place> places_, moved_;
};

}  // namespace typodont::haptics
