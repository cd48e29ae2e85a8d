// Samples of a box that are kept near a body only: memory goes with the body, not with the box around it.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "haptics/import/grid.h"

namespace typodont::haptics::importing {

/// Which blocks of 16³ samples of a box are kept. A block that is not kept lies wholly outside the body or wholly
/// inside it.
struct BlockSet {
  static constexpr int kEdge = 16;
  static constexpr std::size_t kSamples = 4096;
  static constexpr std::int32_t kOutside = -1, kInside = -2;

  glm::ivec3 size{0};              // of the box, samples
  glm::ivec3 count{0};             // of the box, blocks
  std::vector<std::int32_t> slot;  // per block, z fastest: its number among those kept, kOutside or kInside
  std::vector<glm::ivec3> first;   // of each block kept: its first sample

  BlockSet() = default;
  /// `wanted` holds a byte per block, z fastest.
  BlockSet(const glm::ivec3& size, const std::vector<std::uint8_t>& wanted);
  static glm::ivec3 blocks_of(const glm::ivec3& size) { return (size + kEdge - 1) / kEdge; }

  std::size_t block(const glm::ivec3& p) const {
    return (static_cast<std::size_t>(p.x >> 4) * static_cast<std::size_t>(count.y) +
            static_cast<std::size_t>(p.y >> 4)) *
               static_cast<std::size_t>(count.z) +
           static_cast<std::size_t>(p.z >> 4);
  }
  bool holds(const glm::ivec3& p) const {
    return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < size.x && p.y < size.y && p.z < size.z;
  }
  static std::size_t within(const glm::ivec3& p) {
    return static_cast<std::size_t>((p.x & 15) << 8 | (p.y & 15) << 4 | (p.z & 15));
  }
  /// Of sample number i of those kept.
  glm::ivec3 place(std::size_t i) const {
    const auto k = static_cast<int>(i % kSamples);
    return first[i / kSamples] + glm::ivec3(k >> 8, k >> 4 & 15, k & 15);
  }
};

/// Marks, besides the blocks that are marked, all blocks that touch them.
std::vector<std::uint8_t> with_neighbours(const std::vector<std::uint8_t>& blocks, const glm::ivec3& count);

/// Leaves what it makes room for without a value, so that the threads that write first also touch the memory first.
template <class T>
struct NoInitialValue : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = NoInitialValue<U>;
  };
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    if constexpr (sizeof...(Arguments) == 0) {
      ::new (static_cast<void*>(at)) U;
    } else {
      ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
    }
  }
};

/// A value per sample of the blocks kept, and one value each for all outside and all inside.
template <class T>
struct Sparse {
  std::shared_ptr<const BlockSet> set;
  T outside{}, inside{};
  std::vector<T, NoInitialValue<T>> v;

  Sparse() = default;
  Sparse(std::shared_ptr<const BlockSet> blocks, T out, T in)
      : set(std::move(blocks)), outside(out), inside(in), v(set->first.size() * BlockSet::kSamples) {
    fill(out);
  }
  void fill(T value) {
    tbb::parallel_for(std::size_t{0}, set->first.size(),
                      [&](std::size_t b) { std::fill_n(&v[b * BlockSet::kSamples], BlockSet::kSamples, value); });
  }

  bool holds(const glm::ivec3& p) const { return set->holds(p); }
  /// Of a sample in the box: its number among those kept; negative where it is not kept.
  std::ptrdiff_t index(const glm::ivec3& p) const {
    const std::int32_t slot = set->slot[set->block(p)];
    return slot < 0
               ? slot
               : static_cast<std::ptrdiff_t>(static_cast<std::size_t>(slot) * BlockSet::kSamples + BlockSet::within(p));
  }
  glm::ivec3 place(std::size_t i) const { return set->place(i); }
  T operator[](const glm::ivec3& p) const {
    const std::ptrdiff_t i = index(p);
    return i >= 0 ? v[static_cast<std::size_t>(i)] : i == BlockSet::kOutside ? outside : inside;
  }
  T operator()(int x, int y, int z) const { return (*this)[glm::ivec3(x, y, z)]; }
};
using SparseMask = Sparse<std::uint8_t>;

/// work(p, i) for every sample that is kept: place, number. On all cores, a block each.
template <class Work>
void for_each_sample(const BlockSet& set, Work work) {
  tbb::parallel_for(std::size_t{0}, set.first.size(), [&](std::size_t b) {
    const glm::ivec3 lo = set.first[b], hi = glm::min(lo + BlockSet::kEdge, set.size);
    for (int x = lo.x; x < hi.x; ++x) {
      for (int y = lo.y; y < hi.y; ++y) {
        std::size_t i = b * BlockSet::kSamples + BlockSet::within({x, y, lo.z});
        for (int z = lo.z; z < hi.z; ++z, ++i) work(glm::ivec3(x, y, z), i);
      }
    }
  });
}

/// A mask of what test(i, p) holds for.
template <class Test>
SparseMask where(const std::shared_ptr<const BlockSet>& set, bool outside, bool inside, Test test) {
  SparseMask mask(set, outside, inside);
  for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) { mask.v[i] = test(i, p); });
  return mask;
}

/// As for Grid: trilinear and tricubic; beyond the box the value at its wall.
float sample(const Sparse<float>& g, const glm::dvec3& p);
Jet sample_cubic(const Sparse<float>& g, const glm::dvec3& p);

/// As for Grid, where the set has blocks.
Sparse<float> gaussian(const Grid<float>& g, const std::shared_ptr<const BlockSet>& set, double sigma, float outside,
                       float inside);
Sparse<float> gaussian(const Sparse<float>& g, double sigma);

/// (1 + c) G − c G·G with c = 1 + (blur / sigma)²: a smoothing whose second moment is −blur², so that it flattens noise
/// and, to second order, puts curved iso-surfaces back where they were before a Gaussian `blur` (voxels) moved them by
/// blur²·(mean curvature). c is kept at 3 at most, for the noise.
Sparse<float> smooth_in_place(Sparse<float> g, double sigma, double blur);
/// What it leaves of white noise: the norm of its kernel.
double noise_left(double sigma, double blur);

/// A byte per block of the box, z fastest: whether any sample of g after a Gaussian of `sigma` is more than `bound`.
std::vector<std::uint8_t> blocks_above(const Grid<float>& g, double sigma, float bound);

/// Smallest value in the ball of `radius` voxels, at the samples set in `wanted`; at the others their own.
Sparse<float> ball_min(const Sparse<float>& g, double radius, const SparseMask& wanted);
Sparse<float> ball_max(const Sparse<float>& g, double radius, const SparseMask& wanted);

/// Squared distance, in voxels, to the nearest sample set in `mask`; huge where that is more than `reach` along an
/// axis.
Sparse<float> distance_squared_to(const SparseMask& mask, int reach);

/// Bodies of a dense mask that hang together over faces.
struct Bodies {
  std::vector<std::size_t> voxels;  // of each
  glm::ivec3 lo{0}, hi{-1};         // bounds of the largest, inclusive; none where lo > hi
};
Bodies find_bodies(const Mask& mask);

/// Of all samples of the box those in blocks that hold any of the mask, and in the blocks next to them.
double share_near(const Mask& mask);

struct SparseComponents {
  Sparse<std::int32_t> label;       // 0: not in the mask; 1, 2, …; in blocks not kept it is not told
  std::vector<std::size_t> voxels;  // of component i at [i]; [0] counts nothing
  std::int32_t largest() const;     // 0 when there is none
};
/// Connected over faces (6) or also over edges and corners (26; blocks that are not kept always over faces).
SparseComponents components(const SparseMask& mask, bool corners = false);

struct Reached {
  SparseMask samples;
  std::vector<std::uint8_t> blocks;  // of those not kept, by their place in BlockSet::slot
};
/// What of `open` hangs together with the walls of the box.
Reached reached_from_walls(const SparseMask& open);

}  // namespace typodont::haptics::importing
