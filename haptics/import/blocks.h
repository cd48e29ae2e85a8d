// Sparse volumes: samples are stored only near a body, so the memory depends on the size of the body, not of the box
// around it.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "haptics/import/grid.h"

namespace typodont::haptics::importing {

/// The stored blocks of 16³ samples of a box. Blocks that are not stored lie completely outside or completely inside
/// the body.
struct BlockSet {
  static constexpr int kEdge = 16;
  static constexpr std::size_t kSamples = 4096;
  static constexpr std::int32_t kOutside = -1, kInside = -2;

  glm::ivec3 size{0};   // size of the box in samples
  glm::ivec3 count{0};  // size of the box in blocks
  // For each block of the box (z runs fastest): its index among the stored blocks, or kOutside or kInside.
  std::vector<std::int32_t> slot;
  std::vector<glm::ivec3> first;  // position in the box of each stored block's first sample

  BlockSet() = default;
  /// `wanted`: for each block one byte, which is not zero if the block is stored; z runs fastest.
  BlockSet(const glm::ivec3& size, const std::vector<std::uint8_t>& wanted);
  static glm::ivec3 blocks_of(const glm::ivec3& size) { return (size + kEdge - 1) / kEdge; }

  std::size_t block(const glm::ivec3& p) const { return voxel_index(p >> 4, count); }
  bool holds(const glm::ivec3& p) const { return in_grid(p, size); }
  static std::size_t within(const glm::ivec3& p) {
    return static_cast<std::size_t>((p.x & 15) << 8 | (p.y & 15) << 4 | (p.z & 15));
  }
  /// Position in the box of stored sample i.
  glm::ivec3 place(std::size_t i) const {
    const auto k = static_cast<int>(i % kSamples);
    return first[i / kSamples] + glm::ivec3(k >> 8, k >> 4 & 15, k & 15);
  }
};

/// Stores all blocks of a box of `size` samples.
inline std::shared_ptr<const BlockSet> whole_box(const glm::ivec3& size) {
  return std::make_shared<const BlockSet>(size, std::vector<std::uint8_t>(voxel_count(BlockSet::blocks_of(size)), 1));
}

/// Returns the marked blocks and all blocks that touch them.
std::vector<std::uint8_t> with_neighbours(const std::vector<std::uint8_t>& blocks, const glm::ivec3& count);

/// Allocator that leaves values uninitialised. A memory page is then placed near the core that first writes to it.
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

/// Values of the stored blocks, with one common value for all blocks outside and one for all blocks inside.
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
    for_each_in_parallel(set->first.size(),
                         [&](std::size_t b) { std::fill_n(&v[b * BlockSet::kSamples], BlockSet::kSamples, value); });
  }

  bool holds(const glm::ivec3& p) const { return set->holds(p); }
  /// Index of a stored sample; negative: it is not stored.
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

/// Calls work(position, index) or work(index) for every sample of stored block `b`.
template <class Work>
void for_each_sample_of(const BlockSet& set, std::size_t b, const Work& work) {
  const glm::ivec3 lo = set.first[b], hi = glm::min(lo + BlockSet::kEdge, set.size);
  for (int x = lo.x; x < hi.x; ++x) {
    for (int y = lo.y; y < hi.y; ++y) {
      std::size_t i = b * BlockSet::kSamples + BlockSet::within({x, y, lo.z});
      for (int z = lo.z; z < hi.z; ++z, ++i) {
        if constexpr (std::invocable<const Work&, std::size_t>)
          work(i);
        else
          work(glm::ivec3(x, y, z), i);
      }
    }
  }
}
/// Calls work(position, index) or work(index) for every stored sample, on all cores.
template <class Work>
void for_each_sample(const BlockSet& set, const Work& work) {
  for_each_in_parallel(set.first.size(), [&](std::size_t b) { for_each_sample_of(set, b, work); });
}

/// Mask of the stored samples for which test(index, position) or test(index) is true. `outside`, `inside`: values of
/// blocks that are not stored.
template <class Test>
SparseMask where(const std::shared_ptr<const BlockSet>& set, bool outside, bool inside, Test test) {
  SparseMask mask(set, outside, inside);
  for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) {
    if constexpr (std::invocable<Test, std::size_t>)
      mask.v[i] = test(i);
    else
      mask.v[i] = test(i, p);
  });
  return mask;
}

/// Interpolation at p: sample() is trilinear, sample_cubic() is tricubic with gradient. Outside the box: nearest point.
float sample(const Sparse<float>& g, const glm::dvec3& p);
Jet sample_cubic(const Sparse<float>& g, const glm::dvec3& p);

/// Smooths a volume with a Gaussian along each axis. Outside the volume, samples have the value of the nearest border
/// sample. With a `set` or sparse volume, smooths only stored samples. `sigma`: voxels.
Grid<float> gaussian(const Grid<float>& g, double sigma);
Sparse<float> gaussian(const Grid<float>& g, const std::shared_ptr<const BlockSet>& set, double sigma, float outside,
                       float inside);
Sparse<float> gaussian(const Sparse<float>& g, double sigma);

/// Smooths a volume with the kernel (1 + c) G − c G∗G. G: Gaussian; c = 1 + (blur / sigma)² ≤ 3. Blur displaces curved
/// iso-surfaces by blur² · mean curvature; the kernel's second moment −blur² moves them back.
Sparse<float> smooth_in_place(Sparse<float> g, double sigma, double blur);
/// The factor c in the kernel of smooth_in_place(): 1 + (blur / sigma)², at most 3.
double sharpening(double sigma, double blur);
/// Standard deviation of white noise after smooth_in_place() divided by that before it.
double noise_left(double sigma, double blur);

/// Marks blocks (one byte each, z runs fastest) that contain a sample above `bound` after a Gaussian of `sigma` voxels.
std::vector<std::uint8_t> blocks_above(const Grid<float>& g, double sigma, float bound);

/// Smallest (ball_max: largest) value within `radius` voxels of each sample in the mask `wanted`.
Sparse<float> ball_min(const Sparse<float>& g, double radius, const SparseMask& wanted);
Sparse<float> ball_max(const Sparse<float>& g, double radius, const SparseMask& wanted);

/// Squared distance to the mask in voxels²; very large if the mask is farther than `reach` along an axis.
Sparse<float> distance_squared_to(const SparseMask& mask, int reach);

/// A connected component of a dense mask.
struct Body {
  std::size_t voxels = 0;    // number of the component's voxels
  std::size_t bright = 0;    // number of the component's voxels with the mask's value kBrightVoxel
  glm::ivec3 lo{0}, hi{-1};  // first and last sample of the component's bounding box
};
inline constexpr std::uint8_t kBrightVoxel = 2;
/// Finds the bodies: components whose samples are connected over faces.
std::vector<Body> find_bodies(const Mask& mask);
/// Counts bodies that are connected over faces, edges or corners. `read(x, y, row)` writes one byte per sample along z.
std::size_t count_bodies(const glm::ivec3& size, const std::function<void(int, int, std::span<std::uint8_t>)>& read);
/// Returns the index of the largest body with teeth, or else of the largest body; 0 if there is none. A body has teeth
/// if it has at least `min_bright` bright voxels, and at least a tenth as many as the body with the most.
std::size_t main_body(const std::vector<Body>& bodies, double min_bright);

/// Fraction of the box that is filled by blocks with samples of the mask and by their neighbour blocks.
double fraction_near(const Mask& mask);

struct SparseComponents {
  // Number of the component, from 1; 0 outside the mask; undefined for samples that are not stored.
  Sparse<std::int32_t> label;
  std::vector<std::size_t> voxels;  // number of voxels of each component; element 0 is unused
  // For blocks that are not stored: number of their component. Same indices as BlockSet::slot.
  std::vector<std::int32_t> blocks;
  std::int32_t largest() const;  // number of the largest component; 0 if there is none
};
/// Components connected over faces; `corners`: also over edges and corners. Blocks that are not stored connect only
/// over faces.
SparseComponents components(const SparseMask& mask, bool corners = false);
/// Components of a dense mask over faces; all blocks are stored.
SparseComponents components(const Mask& mask);

struct Reached {
  SparseMask samples;
  // For each block that is not stored (indices as in BlockSet::slot): 1 if it is connected to the walls of the box.
  std::vector<std::uint8_t> blocks;
};
/// Finds the part of the mask `open` that is connected to the walls of the box.
Reached reached_from_walls(const SparseMask& open);

}  // namespace typodont::haptics::importing
