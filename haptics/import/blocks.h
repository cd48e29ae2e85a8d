// Samples stored only near a body: memory follows the body, not its box.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "haptics/import/grid.h"

namespace typodont::haptics::importing {

/// Blocks of 16³ samples; those not stored lie wholly outside or inside.
struct BlockSet {
  static constexpr int kEdge = 16;
  static constexpr std::size_t kSamples = 4096;
  static constexpr std::int32_t kOutside = -1, kInside = -2;

  glm::ivec3 size{0};   // size of the box in samples
  glm::ivec3 count{0};  // size of the box in blocks
  // per block, z fastest: index among the stored ones, kOutside or kInside
  std::vector<std::int32_t> slot;
  std::vector<glm::ivec3> first;  // position of the first sample of each stored block

  BlockSet() = default;
  /// `wanted`: one byte per block, z fastest.
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
  /// Position of the stored sample i.
  glm::ivec3 place(std::size_t i) const {
    const auto k = static_cast<int>(i % kSamples);
    return first[i / kSamples] + glm::ivec3(k >> 8, k >> 4 & 15, k & 15);
  }
};

/// Marked blocks and all that touch one.
std::vector<std::uint8_t> with_neighbours(const std::vector<std::uint8_t>& blocks, const glm::ivec3& count);

/// Uninitialised: a page is first written by, and so lies near, the thread that uses it.
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

/// Values of stored blocks, one common value outside and one inside.
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
  /// Negative: not stored.
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

/// work(position, index) for every stored sample, on all cores.
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

/// Samples with test(index, position).
template <class Test>
SparseMask where(const std::shared_ptr<const BlockSet>& set, bool outside, bool inside, Test test) {
  SparseMask mask(set, outside, inside);
  for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) { mask.v[i] = test(i, p); });
  return mask;
}

/// Trilinear, tricubic; outside the box the nearest point's value.
float sample(const Sparse<float>& g, const glm::dvec3& p);
Jet sample_cubic(const Sparse<float>& g, const glm::dvec3& p);

/// `sigma` in voxels; stored samples only.
Sparse<float> gaussian(const Grid<float>& g, const std::shared_ptr<const BlockSet>& set, double sigma, float outside,
                       float inside);
Sparse<float> gaussian(const Sparse<float>& g, double sigma);

/// Kernel (1 + c) G − c G∗G, c = 1 + (blur / sigma)² ≤ 3. Its second moment −blur² moves curved iso-surfaces, displaced
/// by blur² · mean curvature, back to second order.
Sparse<float> smooth_in_place(Sparse<float> g, double sigma, double blur);
/// c of smooth_in_place().
double sharpening(double sigma, double blur);
/// Factor of white noise's σ in smooth_in_place().
double noise_left(double sigma, double blur);

/// Blocks (bytes, z fastest) with a sample above `bound` after smoothing by `sigma` (voxels).
std::vector<std::uint8_t> blocks_above(const Grid<float>& g, double sigma, float bound);

/// Smallest (ball_max: largest) value in a ball of `radius` voxels, for samples in `wanted`.
Sparse<float> ball_min(const Sparse<float>& g, double radius, const SparseMask& wanted);
Sparse<float> ball_max(const Sparse<float>& g, double radius, const SparseMask& wanted);

/// voxels²; very large beyond `reach` along an axis.
Sparse<float> distance_squared_to(const SparseMask& mask, int reach);

/// A connected component of a dense mask.
struct Body {
  std::size_t voxels = 0;    // number of the component's voxels
  std::size_t bright = 0;    // number of the component's voxels with the mask's value kBrightVoxel
  glm::ivec3 lo{0}, hi{-1};  // first and last sample of the component's bounding box
};
inline constexpr std::uint8_t kBrightVoxel = 2;
/// Connected over faces.
std::vector<Body> find_bodies(const Mask& mask);
/// Over faces, edges and corners. `read(x, y, row)`: one byte per sample along z.
std::size_t count_bodies(const glm::ivec3& size, const std::function<void(int, int, std::span<std::uint8_t>)>& read);
/// Largest body with teeth (a tenth of the most bright voxels, at least `least_bright`), else the largest. Splinters do
/// not count. 0: no body.
std::size_t main_body(const std::vector<Body>& bodies, double least_bright);

/// Fraction of the box in blocks of the mask and their neighbours.
double fraction_near(const Mask& mask);

struct SparseComponents {
  // 1, 2, …; 0 outside the mask; undefined where not stored
  Sparse<std::int32_t> label;
  std::vector<std::size_t> voxels;  // element 0 unused
  // component of blocks not stored, indexed as BlockSet::slot
  std::vector<std::int32_t> blocks;
  std::int32_t largest() const;  // number of the largest component; 0 if there is none
};
/// Over faces, or with `corners` also edges and corners; blocks not stored only over faces.
SparseComponents components(const SparseMask& mask, bool corners = false);

struct Reached {
  SparseMask samples;
  // blocks not stored, as BlockSet::slot: 1 if connected to the walls
  std::vector<std::uint8_t> blocks;
};
/// Part of `open` connected to the walls.
Reached reached_from_walls(const SparseMask& open);

}  // namespace typodont::haptics::importing
