#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <random>
#include <utility>

#include "engine/base/dispatch.h"
#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/contact/packing/depth_field.h"
#include "haptics/packing.h"

namespace typodont::haptics {

namespace {

using packing::DepthField;

// Lengths are in voxels, unless m is stated.

constexpr int kEdge = 4;  // grid nodes along each edge of a block
constexpr int kNodes = kEdge * kEdge * kEdge;
// Free radius of a grid node: radius of the largest sphere that fits around the node. The stored value is limited to
// this multiple of the largest allowed radius.
constexpr float kFullDepths = 2;
constexpr double kFirstSpacing = 1 / 3.0;  // spacing of the first grid divided by the largest allowed radius
// In grid spacings. When the largest free radius of all nodes is smaller than this, a finer grid is made.
constexpr double kFinest = 0.9;
constexpr double kFiner = 1.5;  // spacing of a grid divided by the spacing of the next finer grid
// Smallest radius of a sphere in grid spacings. A gap for a smaller sphere is filled later, with a finer grid.
constexpr double kMinRadius = 0.3;
// Placing is postponed if the ratio of the sphere's radius to the stored free radius of its node is below this.
constexpr double kAsExpected = 0.8;
constexpr double kMaxTravel = 1.0;  // in grid spacings, largest distance of a sphere's centre from its node
constexpr double kLastStep = 0.02;  // grid spacings, last step of the search for the centre
// voxels; at this spacing of the grid, the packing is complete
constexpr double kMinSpacing = 0.004;
constexpr double kMaxPerVoxel = 64;  // largest number of spheres per voxel; the field does not resolve more

/// Directions that are distributed evenly over the sphere (Fibonacci lattice).
template <std::size_t kCount>
std::array<dvec3, kCount> even_directions() {
  std::array<dvec3, kCount> d;
  for (std::size_t i = 0; i < kCount; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / kCount, turn = 2.399963229728653 * static_cast<double>(i);
    d[i] = dvec3(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z);
  }
  return d;
}

struct Placed {
  dvec3 p;
  double r;
};

/// Reduces the free radii of a block's nodes after a sphere was placed. `to`: vector from the sphere's centre to the
/// first node. Returns true if a free radius became smaller.
TYPODONT_DISPATCH("avx2", "default")
bool lower_free(float* free, const glm::vec3& to, float step, float radius) {
  int lowered = 0;
  for (int n = 0; n < kNodes; ++n) {
    const float x = to.x + step * static_cast<float>(n >> 4), y = to.y + step * static_cast<float>(n >> 2 & 3),
                z = to.z + step * static_cast<float>(n & 3);
    const float left = std::sqrt(x * x + y * y + z * z) - radius;
    lowered |= left < free[n];
    free[n] = left < free[n] ? left : free[n];
  }
  return lowered != 0;
}

/// Priority of a node. First come nodes where the largest allowed sphere fits, those with the least space first, so
/// that spheres lie close together. Then come the other nodes, by free radius.
float key_of(float free, float limit) {
  const float full = kFullDepths * limit, tight = (1 + kFullDepths) * limit - (free < full ? free : full);
  return free < limit ? free : tight;
}

/// Largest priority (key_of) of a block's nodes; 0: no node has a positive priority.
TYPODONT_DISPATCH("avx2", "default")
float max_key(const float* free, float limit) {
  constexpr int kLanes = 8;
  float key[kLanes] = {};
  for (int n = 0; n < kNodes; n += kLanes) {
    for (int k = 0; k < kLanes; ++k) {
      const float own = key_of(free[n + k], limit);
      key[k] = key[k] < own ? own : key[k];
    }
  }
  float most = 0;
  for (const float k : key) most = most < k ? k : most;
  return most;
}

class Packer {
 public:
  Packer(const DepthField& field, double limit, std::uint64_t seed) : field_(field), limit_(limit) {
    std::mt19937_64 random(seed);
    for (int a = 0; a < 3; ++a) shift_[a] = static_cast<double>(random() >> 11) * 0x1p-53;
    make_grid(kFirstSpacing * limit);
  }

  /// Places the next sphere. Returns false if there is no space for one, even on the finest grid.
  bool place(Placed& placed, Tissue& label) {
    while (true) {
      const int b = top_block();
      if (b < 0 || free_radius(b) < kFinest * spacing_) {
        if (spacing_ < kMinSpacing) return false;
        make_grid(spacing_ / kFiner);
        continue;
      }
      const auto [node, key] = best_node(b);
      Placed found = refined(node_position(b, node));
      Tissue tissue = Tissue::kAir;
      shrink_into(found, tissue);
      float& free = blocks_[static_cast<std::size_t>(b)].free[static_cast<std::size_t>(node)];
      if (found.r < kMinRadius * spacing_ || tissue == Tissue::kAir) {
        free = 0;
        renew_key(b);
        continue;
      }
      // The sphere is smaller than the stored free radius of its node, so another node may have more space.
      if (found.r < kAsExpected * std::min(static_cast<double>(free), limit_)) {
        free = static_cast<float>(found.r);
        renew_key(b);
        continue;
      }
      add(found);
      // Usually the sphere covers its node. If the search moved the sphere too far away, the node is marked as used.
      if (key_of(free) >= key) free = 0, renew_key(b);
      placed = found, label = tissue;
      return true;
    }
  }

  /// Radius of the largest sphere that still fits between the placed spheres.
  double max_hole() {
    double most = 0;
    for (int tries = 0; tries < 4096; ++tries) {
      const int b = top_block();
      if (b < 0 || free_radius(b) + spacing_ < most) break;
      const auto [node, key] = best_node(b);
      Placed found = refined(node_position(b, node));
      Tissue tissue = Tissue::kAir;
      shrink_into(found, tissue);
      most = std::max(most, found.r);
      blocks_[static_cast<std::size_t>(b)].free[static_cast<std::size_t>(node)] = 0;
      renew_key(b);
    }
    return most;
  }

 private:
  /// 4³ grid nodes with their free radii; at 0 or less, no sphere fits at the node.
  struct Block {
    alignas(32) float free[kNodes];
    glm::ivec3 at;  // position in the grid of blocks
    float key;
  };
  struct Entry {
    float key;
    int block;
    bool operator<(const Entry& o) const { return key != o.key ? key < o.key : block > o.block; }
  };

  float key_of(float free) const { return haptics::key_of(free, static_cast<float>(limit_)); }
  double free_radius(int b) const {
    return std::min(static_cast<double>(blocks_[static_cast<std::size_t>(b)].key), limit_);
  }

  dvec3 node_position(int b, int node) const {
    const glm::ivec3 first = kEdge * blocks_[static_cast<std::size_t>(b)].at;
    return origin_ + spacing_ * dvec3(first + glm::ivec3(node / 16, node / 4 % 4, node % 4));
  }
  int cell(const glm::ivec3& at) const { return (at.x * cells_.y + at.y) * cells_.z + at.z; }
  glm::ivec3 cell_of(const dvec3& p) const {
    return glm::clamp(glm::ivec3(glm::floor((p - origin_) / (kEdge * spacing_))), glm::ivec3(0), cells_ - 1);
  }

  int top_block() {
    while (!queue_.empty()) {
      const Entry top = queue_.top();
      const float now = blocks_[static_cast<std::size_t>(top.block)].key;
      if (now > 0 && now == top.key) return top.block;
      queue_.pop();
      if (now > 0 && now < top.key) queue_.push({now, top.block});
    }
    return -1;
  }
  std::pair<int, float> best_node(int b) const {
    const Block& block = blocks_[static_cast<std::size_t>(b)];
    int best = 0;
    float key = -1;
    for (int i = 0; i < kNodes; ++i) {
      if (const float k = key_of(block.free[i]); k > key) key = k, best = i;
    }
    return {best, key};
  }
  void renew_key(int b) {
    Block& block = blocks_[static_cast<std::size_t>(b)];
    const float key = max_key(block.free, static_cast<float>(limit_));
    const bool raised = key > block.key;
    block.key = key;
    if (raised) queue_.push({key, b});
  }

  /// Calls use(i) for spheres that overlap the ball at p with radius `reach`, for some of them repeatedly.
  template <class F>
  void for_spheres_near(const dvec3& p, double reach, F&& use) const {
    const glm::ivec3 lo = cell_of(p - reach), hi = cell_of(p + reach);
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
      for (int link = first_link_[static_cast<std::size_t>(cell({x, y, z}))]; link >= 0;
           link = links_[static_cast<std::size_t>(link)].next) {
        use(links_[static_cast<std::size_t>(link)].sphere);
      }
    });
  }
  template <class F>
  void for_blocks_near(const dvec3& p, double reach, F&& use) const {
    const glm::ivec3 lo = cell_of(p - reach), hi = cell_of(p + reach);
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
      if (const int b = block_at_[static_cast<std::size_t>(cell({x, y, z}))]; b >= 0) use(b);
    });
  }
  void link(int i) {
    const Placed& s = placed_[static_cast<std::size_t>(i)];
    const glm::ivec3 lo = cell_of(s.p - s.r), hi = cell_of(s.p + s.r);
    const double edge = kEdge * spacing_;
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
      const dvec3 low = origin_ + edge * dvec3(x, y, z);
      const dvec3 off = s.p - glm::clamp(s.p, low - 1e-6, low + edge + 1e-6);
      if (glm::dot(off, off) > s.r * s.r) return;
      int& head = first_link_[static_cast<std::size_t>(cell({x, y, z}))];
      links_.push_back({i, head});
      head = static_cast<int>(links_.size()) - 1;
    });
  }

  bool has_depth(const glm::ivec3& cell) const {
    for (int i = 0; i < kNodes; ++i) {
      const glm::ivec3 node = kEdge * cell + glm::ivec3(i / 16, i / 4 % 4, i % 4);
      if (field_.at(origin_ + spacing_ * dvec3(node)) > 0) return true;
    }
    return false;
  }

  /// Makes a grid of nodes whose free radii take all placed spheres into account.
  void make_grid(double spacing) {
    const double max_free = queue_.empty() ? 1e30 : (kFinest + 1) * spacing_;
    spacing_ = spacing;
    origin_ = -(1.0 + shift_) * spacing_;
    cells_ = glm::ivec3(glm::ceil((dvec3(field_.size()) - origin_) / (kEdge * spacing_))) + 1;
    const std::size_t cell_count = voxel_count(cells_);
    first_link_.assign(cell_count, -1);
    links_.clear();
    blocks_.clear();
    queue_ = {};
    block_at_.assign(cell_count, -1);
    for (std::size_t i = 0; i < placed_.size(); ++i) link(static_cast<int>(i));

    // Adds blocks that may contain tissue. Their free radii start at the maximum.
    const double half_diagonal = 0.5 * std::sqrt(3.0) * (kEdge - 1) * spacing_;
    const auto most = static_cast<float>(kFullDepths * limit_);
    for_each_voxel(cells_, [&](int x, int y, int z) {
      const dvec3 middle = origin_ + spacing_ * (dvec3(kEdge * glm::ivec3(x, y, z)) + 0.5 * (kEdge - 1));
      const double depth = field_.at(middle);
      if (depth < -1.2 * half_diagonal - 1 || (depth <= 0 && !has_depth({x, y, z}))) return;
      block_at_[static_cast<std::size_t>(cell({x, y, z}))] = static_cast<int>(blocks_.size());
      Block& block = blocks_.emplace_back();
      std::fill(block.free, block.free + kNodes, most);
      block.at = {x, y, z};
    });
    // New spheres are hardly larger than the last ones, so a placed sphere reduces free radii only in nearby blocks.
    for (const Placed& s : placed_) {
      for_blocks_near(s.p, s.r + std::min(max_free, kFullDepths * limit_),
                      [&](int b) { lower(blocks_[static_cast<std::size_t>(b)], s); });
    }
    // Limits each free radius to the node's depth in the tissue, and removes blocks without space.
    std::size_t kept = 0;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      Block& block = blocks_[b];
      block.key = 0;
      for (int n = 0; n < kNodes; ++n) {
        if (!(block.free[n] > 0)) continue;
        block.free[n] = std::min(static_cast<float>(field_.at(node_position(static_cast<int>(b), n))), block.free[n]);
        block.key = std::max(block.key, key_of(block.free[n]));
      }
      int& at = block_at_[static_cast<std::size_t>(cell(block.at))];
      at = -1;
      if (!(block.key > 0)) continue;
      at = static_cast<int>(kept);
      queue_.push({block.key, at});
      blocks_[kept++] = block;
    }
    blocks_.resize(kept);
  }

  bool lower(Block& block, const Placed& s) const {
    return lower_free(block.free, glm::vec3(origin_ + kEdge * spacing_ * dvec3(block.at) - s.p),
                      static_cast<float>(spacing_), static_cast<float>(s.r));
  }

  void add(const Placed& s) {
    const int i = static_cast<int>(placed_.size());
    placed_.push_back(s);
    link(i);
    // Free radii are limited, so the sphere s changes only the free radii of nodes within s.r + `most` of its centre.
    const double most = s.r < limit_ ? s.r + 2 * spacing_ : kFullDepths * limit_;
    for_blocks_near(s.p, s.r + most, [&](int b) {
      Block& block = blocks_[static_cast<std::size_t>(b)];
      if (!(block.key > 0)) return;
      if (lower(block, s)) renew_key(b);
    });
  }

  /// Searches the best centre of a sphere near `node`: tests evenly distributed directions, and halves the step.
  Placed refined(const dvec3& node) {
    const Tissue tissue = field_.tissue_at(node);
    const double free_depth = std::min(field_.in(tissue, node), kFullDepths * limit_);
    const double travel = kMaxTravel * spacing_;
    near_.clear();
    ++stamp_;
    stamps_.resize(placed_.size(), 0);
    for_spheres_near(node, std::max(free_depth, 0.0) + 2 * travel, [&](int i) {
      if (std::exchange(stamps_[static_cast<std::size_t>(i)], stamp_) != stamp_)
        near_.push_back(placed_[static_cast<std::size_t>(i)]);
    });
    double best = free_at(node, tissue);
    // Removes from near_ the spheres that are too far away to limit the radius.
    std::erase_if(near_, [&](const Placed& s) { return glm::distance(s.p, node) - s.r > best + 2 * travel; });
    dvec3 at = node;
    static const std::array<dvec3, 14> kAround = even_directions<14>();
    for (double step = 0.5 * spacing_; step > kLastStep * spacing_ && best < limit_;) {
      dvec3 to = at;
      for (const dvec3& d : kAround) {
        const dvec3 p = at + step * d;
        if (glm::distance(p, node) > travel) continue;
        if (const double free = free_at(p, tissue, best); free > best) best = free, to = p;
      }
      if (to == at) step *= 0.5;
      at = to;
    }
    return {at, best};
  }
  /// Radius of the largest sphere at p, at most the allowed one. Below `enough`, may return any value up to `enough`.
  double free_at(const dvec3& p, Tissue tissue, double enough = -1e30) const {
    double free = limit_;
    for (const Placed& s : near_) {
      free = std::min(free, glm::distance(p, s.p) - s.r);
      if (free <= enough) return free;
    }
    return std::min(free, field_.in(tissue, p));
  }

  /// Makes the sphere smaller until it is inside its tissue, because interpolated depths are inexact.
  void shrink_into(Placed& s, Tissue& label) const {
    static const std::array<dvec3, 48> kAround = even_directions<48>();
    label = field_.tissue_at(s.p);
    if (s.r < 0.9 * field_.in(label, s.p) - 0.25) return;
    for (int round = 0; round < 2; ++round) {
      double out = 0;
      for (const dvec3& d : kAround) out = std::max(out, -field_.in(label, s.p + s.r * d));
      if (out <= 0) return;
      s.r -= out;
    }
  }

  const DepthField& field_;
  double limit_;
  dvec3 shift_{0};  // grid spacings, random offset of the grid
  double spacing_ = 0;
  dvec3 origin_{0};
  glm::ivec3 cells_{0};
  // for each cell: its block, and its first link to a sphere
  std::vector<int> block_at_, first_link_;
  struct Link {
    int sphere, next;
  };
  std::vector<Link> links_;
  std::vector<Block> blocks_;
  std::priority_queue<Entry> queue_;
  std::vector<Placed> placed_;
  std::vector<Placed> near_;      // spheres near the position that is being examined
  std::vector<unsigned> stamps_;  // for each sphere: number of the search that last added it to near_
  unsigned stamp_ = 0;
};

}  // namespace

SpherePacking pack_spheres(const DenseTissue& tissue, const PackOptions& options) {
  if (options.spheres < 1 || options.spheres > PackOptions::kMaxSpheres) {
    throw Error("packing", "spheres", fmt::format("{}", options.spheres),
                fmt::format("1 to {}", PackOptions::kMaxSpheres));
  }
  if (!(options.max_radius >= 0) || !std::isfinite(options.max_radius)) {
    throw Error("packing", "largest radius", fmt::format("{} m", options.max_radius), "a length above 0");
  }
  const DepthField field(tissue);
  SpherePacking result;
  result.seed = options.seed;
  result.solid_volume = field.volume();
  double volume = 0;
  for (const double v : result.solid_volume) volume += v;
  if (!(volume > 0)) throw Error("packing", "", "no tissue", "a tissue with a volume");
  result.max_radius =
      options.max_radius > 0
          ? options.max_radius
          : PackOptions::kDefaultMaxRadius * std::cbrt(3 * volume / (4 * kPi * static_cast<double>(options.spheres)));
  const double h = tissue.frame.voxel;
  if (const double most = kMaxPerVoxel * volume / (h * h * h); static_cast<double>(options.spheres) > most) {
    throw Error("packing", "spheres", fmt::format("{}", options.spheres),
                fmt::format("at most {:.0f}, {} in each voxel of tissue", std::floor(most), kMaxPerVoxel));
  }
  Packer packer(field, result.max_radius / h, options.seed);
  for (std::size_t i = 0; i < options.spheres; ++i) {
    if (options.progress && i % 1024 == 0) {
      options.progress(static_cast<double>(i) / static_cast<double>(options.spheres));
    }
    Placed s;
    Tissue label;
    if (!packer.place(s, label)) {
      throw Error("packing", "spheres", fmt::format("{}", options.spheres),
                  fmt::format("at most {}: there is no room for more in this tissue", i));
    }
    result.center.push_back(tissue.frame.to_world(s.p));
    result.radius.push_back(s.r * h);
    result.tissue.push_back(label);
  }
  result.max_hole = packer.max_hole() * h;
  if (options.progress) options.progress(1);
  return result;
}

SpherePacking pack_spheres(const TissueVolume& volume, const PackOptions& options) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  constexpr int kAir = 2;  // voxels of air around the tissue
  DenseTissue dense;
  dense.frame = {volume.frame().to_world(dvec3(lo - kAir)), volume.frame().voxel};
  dense.size = glm::max(hi - lo + 1 + 2 * kAir, glm::ivec3(1));
  dense.band = volume.band();
  dense.distance.resize(voxel_count(dense.size));
  dense.tissue.resize(dense.distance.size());
  volume.copy(lo - kAir, dense.size, dense.distance.data(), dense.tissue.data());
  for (float& d : dense.distance) d *= static_cast<float>(dense.frame.voxel);
  SpherePacking packing = pack_spheres(dense, options);
  packing.tissue_hash = volume.hash();
  return packing;
}

}  // namespace typodont::haptics
