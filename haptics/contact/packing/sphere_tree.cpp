#include "haptics/contact/packing/sphere_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

#include "engine/base/dispatch.h"
#include "haptics/contact/looks.h"
#include "haptics/contact/packing/sphere_lanes.h"

namespace typodont::haptics::packing {

namespace {

constexpr std::size_t kLeafSize = SphereTree::kLeafSize;
// Rounding error of about twelve operations in single precision, divided by the packing's size.
constexpr double kRounding = 2e-6;
constexpr std::size_t kDeepest = SphereTree::kDeepest;

/// contact_time() for eight spheres, bit-identical on every processor.
TYPODONT_DISPATCH("avx2", "default")
void contact_times(const SphereTree::Leaf& leaf, const dvec3& p, double r, const dvec3& m, double* t) {
  for (std::size_t i = 0; i < kLeafSize; ++i) {
    const double time = contact_time({leaf.x[i] - p.x, leaf.y[i] - p.y, leaf.z[i] - p.z}, m, leaf.r[i] + r);
    t[i] = leaf.r[i] > 0 ? time : kNever;
  }
}

/// Bit mask of spheres nearer than `reach` to the segment a–b.
TYPODONT_INLINE unsigned near_in(const SphereTree::Leaf& leaf, const dvec3& a, const dvec3& b, double reach) {
  D8 x, y, z, r;
  read_lanes(x, leaf.x), read_lanes(y, leaf.y), read_lanes(z, leaf.z), read_lanes(r, leaf.r);
  D8 off_x, off_y, off_z;
  offsets_from_segment(x, y, z, a, b, off_x, off_y, off_z);
  const D8 near = r + reach;
  return bits_of((r > D8{}) & (off_x * off_x + off_y * off_y + off_z * off_z < near * near));
}

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
unsigned near_lanes(const SphereTree::Leaf& leaf, const dvec3& a, const dvec3& b, double reach) {
  return near_in(leaf, a, b, reach);
}

/// Computes the distance of p from each sphere's surface, minus `offset`. Returns the mask of results below `most`.
TYPODONT_INLINE unsigned gaps_in(const SphereTree::Leaf& leaf, const dvec3& p, double offset, double most, D8& gap) {
  D8 x, y, z, r;
  read_lanes(x, leaf.x), read_lanes(y, leaf.y), read_lanes(z, leaf.z), read_lanes(r, leaf.r);
  x -= p.x, y -= p.y, z -= p.z;
  gap = x * x + y * y + z * z;
  take_root(gap);
  gap = gap - r - offset;
  return bits_of((r > D8{}) & (gap < D8{} + most));
}

/// Computes the bounding box of a leaf's spheres relative to `origin`, enlarged by `rounding_margin`.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void box_of(const SphereTree::Leaf& leaf, const dvec3& origin, double rounding_margin, float* lo, float* hi) {
  D8 r;
  read_lanes(r, leaf.r);
  const I8 full = __builtin_convertvector(r > D8{}, I8);
  const double* const center[3] = {leaf.x, leaf.y, leaf.z};
  for (int a = 0; a < 3; ++a) {
    D8 c;
    read_lanes(c, center[a]);
    c -= origin[a];
    const F8 below = __builtin_convertvector(c - r - rounding_margin, F8),
             above = __builtin_convertvector(c + r + rounding_margin, F8);
    const F8 far = F8{} + 1e30f;
    lo[a] = least_of(full ? below : far);
    hi[a] = -least_of(full ? -above : far);
  }
}

/// Computes the bounding box of all children of a node.
TYPODONT_INLINE void box_of(const SphereTree::Node& node, float* lo, float* hi) {
  for (int a = 0; a < 3; ++a) {
    lo[a] = least_of(*reinterpret_cast<const F8*>(node.lo[a]));
    hi[a] = -least_of(-*reinterpret_cast<const F8*>(node.hi[a]));
  }
}

/// Squared distance between the point `from` and each child's bounding box; infinite: empty child.
TYPODONT_INLINE void far_squared(const SphereTree::Node& node, const glm::vec3& from, F8& far2) {
  far2 = F8{};
  for (int a = 0; a < 3; ++a) {
    const F8 below = *reinterpret_cast<const F8*>(node.lo[a]) - from[a],
             above = F8{} + from[a] - *reinterpret_cast<const F8*>(node.hi[a]);
    const F8 off = below > above ? below : above, out = off > F8{} ? off : F8{};
    far2 += out * out;
  }
}

/// Bit mask of the children whose boxes are within `reach` of `from`.
TYPODONT_INLINE unsigned children_within(const SphereTree::Node& node, const glm::vec3& from, float reach) {
  F8 far2;
  far_squared(node, from, far2);
  return bits_of(far2 <= F8{} + reach * reach);
}

/// A ball around the whole path. If the moving sphere is large, this ball excludes more children than Ray does.
struct Around {
  glm::vec3 middle;
  float reach;
  Around(const dvec3& a, const dvec3& m, double r) : middle(a + 0.5 * m) {
    reach = static_cast<float>(r + 0.5 * glm::length(m));
  }
};

/// A path for children_hit(), which returns a bit mask of the children whose boxes the path may touch before `until`.
/// `enter`: earliest times of touching, 0..1.
struct Ray {
  F8 origin[3], inverse[3];
  float reach;
};
TYPODONT_INLINE unsigned children_hit(const SphereTree::Node& node, const Ray& ray, float until, F8& enter) {
  F8 from = F8{} - 1e30f, to = F8{} + 1e30f;
  for (int a = 0; a < 3; ++a) {
    const F8 near = (*reinterpret_cast<const F8*>(node.lo[a]) - ray.reach - ray.origin[a]) * ray.inverse[a];
    const F8 far = (*reinterpret_cast<const F8*>(node.hi[a]) + ray.reach - ray.origin[a]) * ray.inverse[a];
    const F8 first = near < far ? near : far, last = near < far ? far : near;
    from = first > from ? first : from;
    to = last < to ? last : to;
  }
  enter = from;
  const F8 zero{}, limit = zero + until;
  const I8 full = *reinterpret_cast<const F8*>(node.lo[0]) <= *reinterpret_cast<const F8*>(node.hi[0]);
  return bits_of((from <= to) & (to >= zero) & (from <= limit) & full);
}

}  // namespace

SphereTree::SphereTree(std::span<const dvec3> center, std::span<const double> radius) {
  const std::size_t n = center.size();
  dvec3 lo(0), hi(0);
  for (std::size_t i = 0; i < n; ++i) {
    lo = i == 0 ? center[i] - radius[i] : glm::min(lo, center[i] - radius[i]);
    hi = i == 0 ? center[i] + radius[i] : glm::max(hi, center[i] + radius[i]);
  }
  origin_ = 0.5 * (lo + hi);
  rounding_margin_ = kRounding * glm::length(hi - lo);

  const std::size_t leaves = std::max<std::size_t>(1, (n + kLeafSize - 1) / kLeafSize);
  sphere_in_.resize(n);
  std::iota(sphere_in_.begin(), sphere_in_.end(), 0);
  std::size_t chunk = kLeafSize;
  while (chunk < n) chunk *= kLeafSize;
  order(center, 0, n, chunk);
  sphere_in_.resize(leaves * kLeafSize, -1);
  place_of_.resize(n);
  leaves_.assign(leaves, Leaf{});
  for (std::size_t s = 0; s < n; ++s) {
    const auto i = static_cast<std::size_t>(sphere_in_[s]);
    place_of_[i] = static_cast<Place>(s);
    Leaf& leaf = leaves_[s / kLeafSize];
    leaf.x[s % kLeafSize] = center[i].x, leaf.y[s % kLeafSize] = center[i].y, leaf.z[s % kLeafSize] = center[i].z;
    leaf.r[s % kLeafSize] = radius[i];
  }
  Node empty;
  for (int a = 0; a < 3; ++a) {
    std::fill(empty.lo[a], empty.lo[a] + kLeafSize, 1e30f);
    std::fill(empty.hi[a], empty.hi[a] + kLeafSize, -1e30f);
  }
  for (std::size_t below = leaves; level_.empty() || below > 1;) {
    below = (below + kLeafSize - 1) / kLeafSize;
    level_.push_back(nodes_.size());
    nodes_.resize(nodes_.size() + below, empty);
  }
  for (std::size_t leaf = 0; leaf < leaves; ++leaf) mend(leaf, /*exactly=*/true);
}

/// Sorts the elements `from` to `to` - 1 of sphere_in_, so that each chunk, each eighth of a chunk and so on contains
/// neighbouring spheres.
void SphereTree::order(std::span<const dvec3> center, std::size_t from, std::size_t to, std::size_t chunk) {
  while (chunk > kLeafSize && to - from <= chunk) chunk /= kLeafSize;
  if (to - from <= kLeafSize) return;
  const std::size_t parts = (to - from + chunk - 1) / chunk;
  dvec3 lo(1e30), hi(-1e30);
  for (std::size_t s = from; s < to; ++s) {
    const dvec3& c = center[static_cast<std::size_t>(sphere_in_[s])];
    lo = glm::min(lo, c), hi = glm::max(hi, c);
  }
  const dvec3 wide = hi - lo;
  const int axis = wide.x >= wide.y && wide.x >= wide.z ? 0 : wide.y >= wide.z ? 1 : 2;
  const std::size_t middle = from + parts / 2 * chunk;
  std::nth_element(
      sphere_in_.begin() + static_cast<std::ptrdiff_t>(from), sphere_in_.begin() + static_cast<std::ptrdiff_t>(middle),
      sphere_in_.begin() + static_cast<std::ptrdiff_t>(to), [&](int i, int j) {
        const double a = center[static_cast<std::size_t>(i)][axis], b = center[static_cast<std::size_t>(j)][axis];
        return a != b ? a < b : i < j;
      });
  order(center, from, middle, chunk);
  order(center, middle, to, chunk);
}

/// Updates bounding boxes from a leaf upwards, up to a box that is unchanged or, if `exactly` is false, large enough.
void SphereTree::mend(std::size_t leaf, bool exactly) noexcept {
  float lo[3], hi[3];
  box_of(leaves_[leaf], origin_, rounding_margin_, lo, hi);
  std::size_t child = leaf;
  for (const std::size_t first : level_) {
    Node& node = nodes_[first + child / kLeafSize];
    const std::size_t k = child % kLeafSize;
    bool same = true, inside = true;
    for (int a = 0; a < 3; ++a) {
      same = same && node.lo[a][k] == lo[a] && node.hi[a][k] == hi[a];
      inside = inside && node.lo[a][k] <= lo[a] && node.hi[a][k] >= hi[a];
    }
    if (same || (inside && !exactly)) return;
    for (int a = 0; a < 3; ++a) node.lo[a][k] = lo[a], node.hi[a][k] = hi[a];
    box_of(node, lo, hi);
    child /= kLeafSize;
  }
}

SphereTree::Hit SphereTree::first_of(std::span<const Place> spheres, const dvec3& p, double r,
                                     const dvec3& m) const noexcept {
  double t[kLeafSize];
  contact_times(lanes_of(spheres), p, r, m, t);
  Hit best;
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    if (!(t[k] <= best.t) || t[k] == kNever) continue;
    const int i = sphere_in(spheres[k]);
    if (t[k] < best.t || i < best.sphere) best = {t[k], i};
  }
  return best;
}

SphereTree::Hit SphereTree::first_hit(const dvec3& p, double r, const dvec3& m) const noexcept {
  ++t_search_counts.spheres;
  Hit best;
  Ray ray;
  const dvec3 from = p - origin_;
  for (int a = 0; a < 3; ++a) {
    // m; a smaller motion along an axis counts as zero, because the boxes have a much larger margin
    const double slow = 1e-6 * rounding_margin_;
    ray.origin[a] = F8{} + static_cast<float>(from[a]);
    ray.inverse[a] = F8{} + (std::abs(m[a]) > slow ? static_cast<float>(1 / m[a]) : 1e25f);
  }
  // Adds the rounding error of single precision.
  ray.reach = static_cast<float>(r + rounding_margin_ + kRounding * (glm::length(m) + glm::length(from)));

  const Around around(from, m, static_cast<double>(ray.reach));
  struct Entry {
    float enter;
    std::uint32_t level, index;
  };
  std::array<Entry, kDeepest*(kLeafSize - 1) + 1> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, static_cast<std::uint32_t>(level_.size()), 0};
  float until = 1;
  while (depth > 0) {
    const Entry at = stack[--depth];
    if (at.enter > until) continue;
    if (at.level == 0) {
      double t[kLeafSize];
      contact_times(leaves_[at.index], p, r, m, t);
      for (std::size_t k = 0; k < kLeafSize; ++k) {
        if (!(t[k] <= best.t) || t[k] == kNever) continue;
        const int id = sphere_in_[at.index * kLeafSize + k];
        if (t[k] < best.t || id < best.sphere) best = {t[k], id};
      }
      if (best) until = std::min(1.0f, static_cast<float>(best.t) * 1.000001f + 1e-12f);
      continue;
    }
    F8 enter;
    const Node& node = nodes_[level_[at.level - 1] + at.index];
    unsigned hit = children_hit(node, ray, until, enter);
    if (hit) hit &= children_within(node, around.middle, around.reach);
    // Pushes the nearest child last onto the stack, so it is visited first.
    const std::size_t first = depth;
    for (; hit; hit &= hit - 1) {
      const int k = std::countr_zero(hit);
      const Entry entry{enter[k], at.level - 1,
                        at.index * static_cast<std::uint32_t>(kLeafSize) + static_cast<std::uint32_t>(k)};
      std::size_t place = depth++;
      for (; place > first && stack[place - 1].enter < entry.enter; --place) stack[place] = stack[place - 1];
      stack[place] = entry;
    }
  }
  return best;
}

unsigned SphereTree::near_of(std::span<const Place> spheres, const dvec3& a, const dvec3& b,
                             double reach) const noexcept {
  return near_lanes(lanes_of(spheres), a, b, reach);
}

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
std::size_t SphereTree::near_segment(const dvec3& a, const dvec3& b, double reach,
                                     std::span<Place> found) const noexcept {
  ++t_search_counts.spheres;
  // m, rounding error of positions in single precision
  const double rounding = kRounding * (glm::length(b - a) + glm::length(a - origin_) + reach);
  const Around around(a - origin_, b - a, reach + rounding_margin_ + rounding);
  std::size_t count = 0;
  std::array<std::pair<std::uint32_t, std::uint32_t>, kDeepest*(kLeafSize - 1) + 1> stack;
  std::size_t depth = 0;
  stack[depth++] = {static_cast<std::uint32_t>(level_.size()), 0};
  while (depth > 0) {
    const auto [level, index] = stack[--depth];
    if (level == 0) {
      for (unsigned bits = near_in(leaves_[index], a, b, reach); bits; bits &= bits - 1) {
        if (count < found.size()) {
          found[count] = static_cast<Place>(index * kLeafSize + static_cast<std::size_t>(std::countr_zero(bits)));
        }
        ++count;
      }
      continue;
    }
    const Node& node = nodes_[level_[level - 1] + index];
    for (unsigned bits = children_within(node, around.middle, around.reach); bits; bits &= bits - 1) {
      stack[depth++] = {level - 1, index * static_cast<std::uint32_t>(kLeafSize) +
                                       static_cast<std::uint32_t>(std::countr_zero(bits))};
    }
  }
  return count;
}

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
std::size_t SphereTree::search_on(PartSearch& search, const dvec3& p, double reach, double offset, std::size_t& leaves,
                                  std::span<Place> found, float* gap) const noexcept {
  ++t_search_counts.spheres;
  const double rounding = kRounding * (glm::length(p - origin_) + reach);
  const Around around(p - origin_, dvec3(0), reach + rounding_margin_ + rounding);
  std::size_t count = 0;
  while (search.depth_ > 0 && leaves > 0 && count + kLeafSize <= found.size()) {
    const auto [level, index] = search.stack_[--search.depth_];
    if (level == 0) {
      --leaves;
      D8 gaps;
      for (unsigned bits = gaps_in(leaves_[index], p, offset, reach - offset, gaps); bits; bits &= bits - 1) {
        const auto k = static_cast<std::size_t>(std::countr_zero(bits));
        found[count] = static_cast<Place>(index * kLeafSize + k);
        gap[count++] = static_cast<float>(gaps[k]);
      }
      continue;
    }
    const Node& node = nodes_[level_[level - 1] + index];
    for (unsigned bits = children_within(node, around.middle, around.reach); bits; bits &= bits - 1) {
      search.stack_[search.depth_++] = {level - 1, index * static_cast<std::uint32_t>(kLeafSize) +
                                                       static_cast<std::uint32_t>(std::countr_zero(bits))};
    }
  }
  return count;
}

/// Calls visit(place, distance from p to the surface) for spheres that may be nearer to p than `most`. visit() may
/// reduce `most`; negative infinity ends the search.
template <class Visit>
void SphereTree::visit_nearest(const dvec3& p, double& most, Visit&& visit) const noexcept {
  const glm::vec3 from(p - origin_);
  struct Entry {
    float far2;
    std::uint32_t level, index;
  };
  std::array<Entry, kDeepest*(kLeafSize - 1) + 1> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, static_cast<std::uint32_t>(level_.size()), 0};
  const auto reach2 = [&] {
    const auto reach = static_cast<float>(std::max(most, 0.0) + rounding_margin_);
    return reach * reach;
  };
  while (depth > 0 && most > -kNever) {
    const auto [entered, level, index] = stack[--depth];
    if (entered > reach2()) continue;
    if (level == 0) {
      const Leaf& leaf = leaves_[index];
      for (std::size_t k = 0; k < kLeafSize; ++k) {
        if (leaf.r[k] > 0) {
          visit(index * kLeafSize + k, glm::distance(p, dvec3(leaf.x[k], leaf.y[k], leaf.z[k])) - leaf.r[k]);
        }
      }
      continue;
    }
    F8 far2;
    far_squared(nodes_[level_[level - 1] + index], from, far2);
    // Pushes the nearest child last onto the stack, so it is visited first.
    const std::size_t first = depth;
    for (unsigned bits = bits_of(far2 <= F8{} + reach2()); bits; bits &= bits - 1) {
      const int k = std::countr_zero(bits);
      const Entry entry{far2[k], level - 1,
                        index * static_cast<std::uint32_t>(kLeafSize) + static_cast<std::uint32_t>(k)};
      std::size_t place = depth++;
      for (; place > first && stack[place - 1].far2 < entry.far2; --place) stack[place] = stack[place - 1];
      stack[place] = entry;
    }
  }
}

double SphereTree::clearance(const dvec3& p, double most, double enough) const noexcept {
  ++t_search_counts.spheres;
  double nearest = most;
  visit_nearest(p, most, [&](std::size_t, double off) {
    nearest = std::min(nearest, off);
    most = nearest <= enough ? -kNever : nearest;
  });
  return nearest;
}

bool SphereTree::touches(const dvec3& p, double r) const noexcept {
  ++t_search_counts.spheres;
  bool touches = false;
  double most = r;
  visit_nearest(p, most, [&](std::size_t, double off) {
    touches = touches || off <= r;
    if (touches) most = -kNever;
  });
  return touches;
}

int SphereTree::nearest(const dvec3& p) const noexcept {
  double most = 1e15;
  int best = -1;
  visit_nearest(p, most, [&](std::size_t place, double off) {
    if (off < most) most = off, best = sphere_in_[place];
  });
  return best;
}

}  // namespace typodont::haptics::packing
