// What a moving patch gains. The servo keeps the samples that stay, with its cuts, and copies in only the carver's new
// leaves of 8³.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "haptics/volume/label.h"

namespace typodont::haptics {

struct SurfacePatch;

/// Filled by the carver, read by the servo. Allocates at set-up.
class PatchStep {
 public:
  static constexpr int kSide = 8, kSamples = kSide * kSide * kSide;  // per axis, and in all

  /// Uniform distances (or labels and hardness) are one value.
  struct Leaf {
    glm::ivec3 lo;  // position of its first sample in voxels
    bool one_distance, one_label;
    float distance;         // voxels
    Tissue label;           // label.h
    std::uint8_t hardness;  // dense_tissue.h
  };
  /// z fastest; valid where the leaf is not uniform. `hardness`: null without hardness per voxel.
  struct Samples {
    float* distance;
    Tissue* label;
    std::uint8_t* hardness;
  };

  /// Of one step by a leaf along all axes, for `edge` leaves each.
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

  /// That fit in memory.
  std::size_t most() const noexcept { return distances_.size() / kSamples; }
  void clear() noexcept { leaves_.clear(); }
  /// The caller then writes samples(size() − 1). Needs memory.
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

/// To the place of its step `fresh` (Snapshot::from), with its data except the samples that stay. `fresh` gets the
/// coarse patch of `patch`.
void take_step(SurfacePatch& patch, SurfacePatch& fresh) noexcept;

}  // namespace typodont::haptics
