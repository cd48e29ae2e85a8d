// Arrays of samples that are stored only near a body, so that memory is proportional to the body, not to its box.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "haptics/import/grid.h"

namespace typodont::haptics::importing {

/// The blocks of 16³ samples of a box that are stored. A block that is not stored lies wholly outside the body or
/// wholly inside it.
struct BlockSet {
  static constexpr int kEdge = 16;
  static constexpr std::size_t kSamples = 4096;
  static constexpr std::int32_t kOutside = -1, kInside = -2;

  glm::ivec3 size{0};              // size of the box in samples
  glm::ivec3 count{0};             // size of the box in blocks
  std::vector<std::int32_t> slot;  // per block, z fastest: its index among the stored blocks, kOutside or kInside
  std::vector<glm::ivec3> first;   // first sample of each stored block

  BlockSet() = default;
  /// `wanted`: one byte per block, z fastest; nonzero: the block is stored.
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
  /// Position of the stored sample with index i.
  glm::ivec3 place(std::size_t i) const {
    const auto k = static_cast<int>(i % kSamples);
    return first[i / kSamples] + glm::ivec3(k >> 8, k >> 4 & 15, k & 15);
  }
};

/// Returns the marked blocks and all blocks that touch them.
std::vector<std::uint8_t> with_neighbours(const std::vector<std::uint8_t>& blocks, const glm::ivec3& count);

/// An allocator that does not initialize elements, so that the first write to a page comes from the thread that uses
/// it.
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

/// One value per sample of the stored blocks, one value for all blocks outside, and one for all blocks inside.
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
  /// Index of a sample of the box among the stored samples; negative if it is not stored.
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

/// Calls work(position, index) for every stored sample, block by block on all cores.
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

/// The mask of the samples for which test(index, position) is true.
template <class Test>
SparseMask where(const std::shared_ptr<const BlockSet>& set, bool outside, bool inside, Test test) {
  SparseMask mask(set, outside, inside);
  for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) { mask.v[i] = test(i, p); });
  return mask;
}

/// Trilinear and tricubic interpolation. Outside the box, the value at its border is used.
float sample(const Sparse<float>& g, const glm::dvec3& p);
Jet sample_cubic(const Sparse<float>& g, const glm::dvec3& p);

/// Gaussian smoothing with `sigma` voxels, only in the stored blocks.
Sparse<float> gaussian(const Grid<float>& g, const std::shared_ptr<const BlockSet>& set, double sigma, float outside,
                       float inside);
Sparse<float> gaussian(const Sparse<float>& g, double sigma);

/// Smoothing with the kernel (1 + c) G − c G·G, where c = 1 + (blur / sigma)²; its second moment is −blur². It
/// reduces noise. To second order it also corrects curved iso-surfaces, which a Gaussian `blur` (voxels) displaced by
/// blur²·(mean curvature). c is limited to 3, because of the noise.
Sparse<float> smooth_in_place(Sparse<float> g, double sigma, double blur);
/// Factor by which smooth_in_place() reduces white noise: the norm of its kernel.
double noise_left(double sigma, double blur);

/// One byte per block of the box, z fastest: 1 if any sample of g, smoothed by a Gaussian of `sigma`, exceeds `bound`.
std::vector<std::uint8_t> blocks_above(const Grid<float>& g, double sigma, float bound);

/// The smallest value in the ball of `radius` voxels (or the largest, for ball_max), at the samples set in `wanted`;
/// other samples keep their values.
Sparse<float> ball_min(const Sparse<float>& g, double radius, const SparseMask& wanted);
Sparse<float> ball_max(const Sparse<float>& g, double radius, const SparseMask& wanted);

/// Squared distance, in voxels, to the nearest sample set in `mask`; a very large value if it is farther than `reach`
/// along an axis.
Sparse<float> distance_squared_to(const SparseMask& mask, int reach);

/// Connected components (over faces) of a dense mask.
struct Bodies {
  std::vector<std::size_t> voxels;  // size of each component
  glm::ivec3 lo{0}, hi{-1};         // bounds of the largest component, inclusive; lo > hi if there is none
};
Bodies find_bodies(const Mask& mask);

/// Fraction of the box's samples that lie in blocks with samples of the mask, or in neighbours of such blocks.
double fraction_near(const Mask& mask);

struct SparseComponents {
  Sparse<std::int32_t> label;       // 0: not in the mask; 1, 2, …; undefined in blocks that are not stored
  std::vector<std::size_t> voxels;  // size of component i; [0] is not used
  std::int32_t largest() const;     // 0 if there is none
};
/// Connected components over faces (6 neighbours), or also over edges and corners (26 neighbours; blocks that are not
/// stored are always connected over faces).
SparseComponents components(const SparseMask& mask, bool corners = false);

struct Reached {
  SparseMask samples;
  std::vector<std::uint8_t> blocks;  // for each block that is not stored, indexed as BlockSet::slot
};
/// The part of `open` that is connected to the walls of the box.
Reached reached_from_walls(const SparseMask& open);

}  // namespace typodont::haptics::importing
