// The samples that a patch (the servo's copy of the tissue around the tool) gains when it moves. The servo keeps the
// samples that stay inside its patch, because it makes its cuts in them itself. So the carver copies only the leaves
// (blocks of 8³ samples) that come in, and the servo copies them to its patch.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "haptics/label.h"

namespace typodont::haptics {

struct SurfacePatch;

/// A list of leaves of the tissue. The carver fills it, and the servo reads it. The memory is allocated at set-up.
class PatchStep {
 public:
  static constexpr int kSide = 8, kSamples = kSide * kSide * kSide;  // samples of a leaf, along each axis and in all

  /// A leaf. If all its samples have the same distance (or label and hardness), only this one value is stored.
  struct Leaf {
    glm::ivec3 lo;  // position of its first sample in voxels
    bool one_distance, one_label;
    float distance;         // voxels
    Tissue label;           // label.h
    std::uint8_t hardness;  // hardness.h
  };
  /// Pointers to the samples of one leaf, z fastest. Only those arrays are valid for which the leaf does not have one
  /// value. `hardness` is null if the tissue has no hardness per voxel.
  struct Samples {
    float* distance;
    Tissue* label;
    std::uint8_t* hardness;
  };

  /// Returns the largest number of leaves that a patch with `edge` leaves along each axis can gain in one step: those
  /// of a step by one leaf along all three axes.
  static std::size_t most_for(int edge) {
    const auto cube = [](std::size_t n) { return n * n * n; };
    return edge < 1 ? 0 : cube(static_cast<std::size_t>(edge)) - cube(static_cast<std::size_t>(edge) - 1);
  }
  /// Allocates memory for `leaves` leaves.
  void reserve(std::size_t leaves) {
    leaves_.reserve(leaves);
    distances_.resize(leaves * kSamples);
    labels_.resize(leaves * kSamples);
  }
  /// Allocates the memory for hardness per voxel.
  void grade() { hardness_.resize(labels_.size()); }

  /// Returns the number of leaves for which there is memory.
  std::size_t most() const noexcept { return distances_.size() / kSamples; }
  void clear() noexcept { leaves_.clear(); }
  /// Appends a leaf; the caller then writes samples(size() − 1). There must be memory for it.
  void add(const Leaf& leaf) { leaves_.push_back(leaf); }
  std::size_t size() const noexcept { return leaves_.size(); }
  const Leaf& leaf(std::size_t i) const noexcept { return leaves_[i]; }
  Samples samples(std::size_t i) noexcept {
    const std::size_t at = i * kSamples;
    return {distances_.data() + at, labels_.data() + at, hardness_.empty() ? nullptr : hardness_.data() + at};
  }

 private:
  std::vector<Leaf> leaves_;
  std::vector<float> distances_;
  std::vector<Tissue> labels_;
  std::vector<std::uint8_t> hardness_;
};

/// Moves `patch` to the place of `fresh`, which is a step from it (Snapshot::from), and gives it all other data of
/// `fresh`, except for the samples that stay inside. `fresh` receives the coarse patch of `patch`.
void take_step(SurfacePatch& patch, SurfacePatch& fresh) noexcept;

}  // namespace typodont::haptics
