// Arrays that store samples only near a body (a connected piece of tissue). So the memory is proportional to the size
// of the body, and not to the size of the box around it.
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

/// The set of the stored blocks of a box. The box is divided into blocks of 16³ samples. A block that is not stored
/// lies completely outside or completely inside the body.
struct BlockSet {
  static constexpr int kEdge = 16;
  static constexpr std::size_t kSamples = 4096;
  static constexpr std::int32_t kOutside = -1, kInside = -2;

  glm::ivec3 size{0};   // size of the box in samples
  glm::ivec3 count{0};  // size of the box in blocks
  // for each block of the box (z fastest): its index among the stored blocks, or kOutside, or kInside
  std::vector<std::int32_t> slot;
  std::vector<glm::ivec3> first;  // position of the first sample of each stored block

  BlockSet() = default;
  /// Makes the set. `wanted` has one byte for each block of the box (z fastest); a block is stored if its byte is not
  /// zero.
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
  /// Returns the position in the box of the stored sample with index i.
  glm::ivec3 place(std::size_t i) const {
    const auto k = static_cast<int>(i % kSamples);
    return first[i / kSamples] + glm::ivec3(k >> 8, k >> 4 & 15, k & 15);
  }
};

/// Returns the blocks whose byte in `blocks` is not zero, and all blocks that touch such a block.
std::vector<std::uint8_t> with_neighbours(const std::vector<std::uint8_t>& blocks, const glm::ivec3& count);

/// An allocator that does not initialise elements. So a page of memory is first written by the thread that later uses
/// it. The system then places the page near this thread's processor core, which makes access faster.
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

/// A sparse array of values. It has one value for each sample of the stored blocks, one common value for all samples
/// outside the body, and one for all samples inside.
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
  /// Returns the index, among the stored samples, of the sample at position p; negative if this sample is not stored.
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

/// Calls work(position, index) for every stored sample, block by block on all processor cores.
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

/// Makes a mask of the samples for which test(index, position) is true.
template <class Test>
SparseMask where(const std::shared_ptr<const BlockSet>& set, bool outside, bool inside, Test test) {
  SparseMask mask(set, outside, inside);
  for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) { mask.v[i] = test(i, p); });
  return mask;
}

/// Both functions return the value at a position between the samples (voxels): sample() by trilinear interpolation,
/// sample_cubic() by tricubic interpolation. Outside the box, the value at the nearest point of the box is used.
float sample(const Sparse<float>& g, const glm::dvec3& p);
Jet sample_cubic(const Sparse<float>& g, const glm::dvec3& p);

/// Smooths with a Gaussian of the standard deviation `sigma` (voxels). Only samples in stored blocks are computed.
Sparse<float> gaussian(const Grid<float>& g, const std::shared_ptr<const BlockSet>& set, double sigma, float outside,
                       float inside);
Sparse<float> gaussian(const Sparse<float>& g, double sigma);

/// Smooths with the kernel (1 + c) G − c G∗G (∗: convolution), where G is a Gaussian of `sigma` (voxels) and c = 1 +
/// (blur / sigma)². This reduces noise and corrects curved iso-surfaces: the scan's blur (a Gaussian of the standard
/// deviation `blur`, voxels) displaces such a surface by blur²·(mean curvature), and the kernel moves the surface back,
/// because the kernel's second moment is −blur². The correction is exact to second order. c is at most 3, because a
/// larger c would increase the noise.
Sparse<float> smooth_in_place(Sparse<float> g, double sigma, double blur);
/// Returns c, the strength of the sharpening in the kernel (1 + c) G − c G∗G of smooth_in_place().
double sharpening(double sigma, double blur);
/// Returns the norm of the kernel of smooth_in_place(). It is the factor by which smooth_in_place() changes the
/// standard deviation of white noise.
double noise_left(double sigma, double blur);

/// Marks each block of the box (one byte per block, z fastest) that has a sample above `bound` after g was smoothed by
/// a Gaussian of `sigma` (voxels).
std::vector<std::uint8_t> blocks_above(const Grid<float>& g, double sigma, float bound);

/// Returns for each sample in `wanted` the smallest value (ball_max: the largest value) in a ball of `radius` voxels
/// around it. Other samples keep their values.
Sparse<float> ball_min(const Sparse<float>& g, double radius, const SparseMask& wanted);
Sparse<float> ball_max(const Sparse<float>& g, double radius, const SparseMask& wanted);

/// Returns for each sample the squared distance (voxels²) to the nearest sample in `mask`. The value is very large if
/// the nearest sample of the mask is farther away than `reach` voxels along an axis.
Sparse<float> distance_squared_to(const SparseMask& mask, int reach);

/// A connected component of a dense mask.
struct Body {
  std::size_t voxels = 0;    // number of the component's voxels
  std::size_t bright = 0;    // number of the component's voxels with the mask's value kBrightVoxel
  glm::ivec3 lo{0}, hi{-1};  // first and last sample of the component's bounding box
};
inline constexpr std::uint8_t kBrightVoxel = 2;
/// Returns the connected components of a dense mask. Samples are connected over faces.
std::vector<Body> find_bodies(const Mask& mask);
/// Returns the number of connected components of a set of samples in a box of `size`. Samples are connected over faces,
/// edges and corners. `read(x, y, row)` writes one byte for each sample of a row along z; the byte is not zero if the
/// sample belongs to the set.
std::size_t count_bodies(const glm::ivec3& size, const std::function<void(int, int, std::span<std::uint8_t>)>& read);
/// Returns the index of the body that is imported. If some bodies have teeth, it is the largest body with teeth.
/// Otherwise it is the largest body. A body has teeth if it has at least a tenth as many bright voxels as the body with
/// the most bright voxels. If that body has fewer than `least_bright` bright voxels, no body has teeth. Splinters
/// (bodies that are much smaller than the largest body) are ignored. Returns 0 if there is no body.
std::size_t main_body(const std::vector<Body>& bodies, double least_bright);

/// Returns which fraction of the box's samples lies in blocks with samples of the mask or in neighbours of such blocks.
double fraction_near(const Mask& mask);

struct SparseComponents {
  // number of each sample's component: 1, 2, …; 0 if the sample is not in the mask; undefined in blocks that are not
  // stored
  Sparse<std::int32_t> label;
  std::vector<std::size_t> voxels;  // number of voxels of component i; element 0 is not used
  // for each block that is not stored (indexed as BlockSet::slot): number of its component, or 0
  std::vector<std::int32_t> blocks;
  std::int32_t largest() const;  // number of the largest component; 0 if there is none
};
/// Finds the connected components of a mask. Samples are connected over faces (6 neighbours), or with `corners` also
/// over edges and corners (26 neighbours). Blocks that are not stored are always connected over faces.
SparseComponents components(const SparseMask& mask, bool corners = false);

struct Reached {
  SparseMask samples;
  // for each block that is not stored (indexed as BlockSet::slot): 1 if it is connected to the walls of the box
  std::vector<std::uint8_t> blocks;
};
/// Returns the part of the mask `open` that is connected to the walls of the box.
Reached reached_from_walls(const SparseMask& open);

}  // namespace typodont::haptics::importing
