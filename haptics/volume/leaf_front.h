// Finds the leaves of the tissue that the next cuts can still change. A leaf contains 8³ samples. The class does for
// the carver (owner of the tissue) what CutFront does for the servo: if the head must move `slack` voxels before any
// sample of a leaf can change, the leaf is skipped until the head has moved so far. Private to haptics/volume.
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

/// The leaves in front of one head that its next cuts can still change (the active front). Carver thread only. A key is
/// a position in units of leaves of 8³ samples.
class LeafFront {
 public:
  using Leaf = openvdb::FloatTree::LeafNodeType;
  using Kept = LeafHistory<openvdb::FloatTree>::Kept;

  static constexpr float kNow = -1e9f, kNever = 1e9f;

  /// The alignment lets a place occupy only one cache line.
  struct alignas(64) Place {
    Leaf* leaf = nullptr;  // the leaf; null: the leaf was not examined yet
    float* samples =
        nullptr;           // the samples of `leaf`; stored here, because reading them from the leaf waits for memory
    Kept* kept = nullptr;  // copy of the leaf (8³ samples) with which the present stroke can be undone; null: no stroke
    bool cut = false;      // true if the leaf (8³ samples) was cut since it was first examined
    std::uint64_t logged = 0;  // last mark (number of a state) after which the leaf was added to the list of writes
    // path length in voxels at which each block of the leaf must be examined again
    std::array<float, Sweep::Leaf::kBlocks> due = {kNow, kNow, kNow, kNow};
  };

  /// A leaf that must be examined now. `key`: its position in leaves. `due`: path length in voxels at which the leaf
  /// must be examined again, the smallest value of its blocks. It is stored separately from the other data, because for
  /// most leaves nothing else is read.
  struct DuePlace {
    glm::ivec3 key;
    Place* place;
    float* due;
  };

  /// Discards the stored position of the head. Must be called if the tissue changes in any other way than by the cuts
  /// of one stroke, or if a leaf is replaced.
  void forget() noexcept { last_.reset(); }

  /// Advances the head to the end of `sweep`, which reaches the leaves (8³ samples) lo..hi, inclusive.
  void advance_to(const Sweep& sweep, const glm::ivec3& lo, const glm::ivec3& hi);
  /// Returns the path length so far (voxels) of the point of the head that has moved farthest.
  float path() const noexcept { return static_cast<float>(path_); }
  /// Returns those of the leaves (8³ samples) lo..hi, inclusive, that must be examined now, in the order of their
  /// keys. They are inside the box of the last call of advance_to(). The result is valid until the next call.
  std::span<const DuePlace> due(const glm::ivec3& lo, const glm::ivec3& hi);

 private:
  // number of leaves (8³ samples) by which the box of stored leaves extends beyond the sweep on each side, so that the
  // box seldom has to move
  static constexpr int kRoom = 2;
  // voxels; at this path length, counting restarts at 0, so that a float resolves the path length to 6e-5 voxel
  static constexpr double kLongest = 512;

  // number of unused elements at the end of due_; a vector load may read beyond the last row
  static constexpr int kUnused = 8;

  void move_window(const glm::ivec3& lo, const glm::ivec3& hi);

  std::optional<Sweep> last_;  // the last motion of the head; no value: the position of the head is unknown
  double path_ = 0;            // voxels, path length of the head's farthest point so far
  glm::ivec3 first_{0}, size_{0};
  std::vector<float> due_, due_moved_;  // with kUnused unused elements at the end
  std::vector<std::int32_t> found_;     // indices of the leaves that due() has found in one row
  std::vector<DuePlace> due_places_;
  std::vector<Place> places_, moved_;
};

}  // namespace typodont::haptics
