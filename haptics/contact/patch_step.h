// The new samples of a tissue patch that moves with the tool. The servo keeps the samples that stay, with its cuts, and
// copies only the new leaves (8³ samples) from the carver.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "haptics/volume/label.h"

namespace typodont::haptics {

struct TissuePatch;

/// Written by the carver, read by the servo. Allocates at set-up only.
class PatchStep {
 public:
  static constexpr int kSide = 8, kSamples = kSide * kSide * kSide;  // samples of a leaf along each axis, and in total

  /// A leaf whose distances (or labels and hardness) are all equal stores only one value.
  struct Leaf {
    glm::ivec3 lo;  // voxels, position of the leaf's first sample
    bool one_distance, one_label;
    float distance;         // voxels, distance of all samples of the leaf
    Tissue label;           // label.h
    std::uint8_t hardness;  // dense_tissue.h
  };
  /// Samples of a leaf that is not uniform; z is the fastest index. `hardness`: null if the tissue has no hardness per
  /// voxel.
  struct Samples {
    float* distance;
    Tissue* label;
    std::uint8_t* hardness;
  };

  /// Number of new leaves if a tissue patch of `edge`³ leaves moves by one leaf along all axes.
  static std::size_t most_for(int edge) {
    const auto cube = [](std::size_t n) { return n * n * n; };
    return edge < 1 ? 0 : cube(static_cast<std::size_t>(edge)) - cube(static_cast<std::size_t>(edge) - 1);
  }
  /// Allocates memory for `leaves` leaves (8³ samples each).
  void reserve(std::size_t leaves) {
    leaves_.reserve(leaves);
    distances_.resize(leaves * kSamples);
    labels_.resize(leaves * kSamples);
  }
  /// Allocates the memory for a hardness at each voxel.
  void grade() { hardness_.resize(labels_.size()); }

  /// Number of leaves that fit in the allocated memory.
  std::size_t most() const noexcept { return distances_.size() / kSamples; }
  void clear() noexcept { leaves_.clear(); }
  /// Adds a leaf; the caller then writes samples(size() − 1). The allocated memory must have room: size() < most().
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

/// Moves `patch` to the position of `fresh`, and copies the new samples (fresh.step) and all other data of `fresh`. In
/// exchange, `fresh` receives the old coarse tissue patch.
void take_step(TissuePatch& patch, TissuePatch& fresh) noexcept;

}  // namespace typodont::haptics
