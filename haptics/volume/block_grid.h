// The storage of the tissue: a sparse grid of blocks of 8³ voxels. Private to haptics/volume.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <type_traits>

#include "engine/base/voxels.h"
#include "haptics/volume/leaf_key.h"
#include "haptics/volume/loose_pieces.h"

namespace typodont::haptics {

/// One value per voxel. A block of 8³ voxels is a tile, which has one value for all voxels, or a leaf with a value for
/// each. A voxel is on if its value was set; the others belong to the surroundings. Many threads read, or one writes.
template <class Value>
class BlockGrid {
  // A node has 16³ blocks.
  static constexpr int kNodeShift = 4, kNodeSide = 1 << kNodeShift;
  static constexpr int kNoNode = std::int32_t{1} << 30;  // no block has such a key

 public:
  using ValueType = Value;
  static constexpr int kSide = kLeafSide, kSize = kSide * kSide * kSide;

  /// z is the fastest index.
  struct Leaf {
    std::array<Value, kSize> values;  // not aligned to cache lines: aligned_alloc() leaves gaps, which slow malloc()
    SolidBits on;                     // bit mask; voxel i is bit i % 64 of word i / 64

    Leaf(Value value, bool is_on) {
      values.fill(value);
      set_all_on(is_on);
    }
    static int index(const glm::ivec3& voxel) {
      constexpr int in = kSide - 1;
      return ((voxel.x & in) * kSide + (voxel.y & in)) * kSide + (voxel.z & in);
    }
    bool is_on(int i) const { return on[static_cast<std::size_t>(i) / 64] >> i % 64 & 1; }
    void set(int i, Value value, bool is_on = true) {
      const std::uint64_t bit = std::uint64_t{1} << i % 64;
      std::uint64_t& word = on[static_cast<std::size_t>(i) / 64];
      word = is_on ? word | bit : word & ~bit;
      values[static_cast<std::size_t>(i)] = value;
    }
    void set_all_on(bool is_on = true) { on.fill(is_on ? ~std::uint64_t{0} : 0); }
    const Value* data() const { return values.data(); }
    Value* data() { return values.data(); }
  };

  struct Block {
    std::unique_ptr<Leaf> leaf;  // null: a tile
    Value tile{};
    bool tile_on = false;

    Block() = default;
    Block(Value value, bool on) : tile(value), tile_on(on) {}
    Block(const Block& other)
        : leaf(other.leaf ? std::make_unique<Leaf>(*other.leaf) : nullptr), tile(other.tile), tile_on(other.tile_on) {}
    Block(Block&&) noexcept = default;
    Block& operator=(Block&&) noexcept = default;
    Value value(int i) const { return leaf ? leaf->values[static_cast<std::size_t>(i)] : tile; }
    bool is_on(int i) const { return leaf ? leaf->is_on(i) : tile_on; }
    /// Turns a tile into a leaf.
    Leaf& touch() {
      if (!leaf) leaf = std::make_unique<Leaf>(tile, tile_on);
      return *leaf;
    }
    void set(int i, Value value) {
      if (leaf || !tile_on || tile != value) touch().set(i, value);
    }
  };

  using Node = std::array<Block, kNodeSide * kNodeSide * kNodeSide>;

  /// `background`: value of all voxels that were never set.
  explicit BlockGrid(Value background = {}) : nowhere_(background, false) {}
  BlockGrid(const BlockGrid& other) : nowhere_(other.nowhere_) {
    for (const auto& [key, node] : other.nodes_) nodes_.emplace(key, std::make_unique<Node>(*node));
  }
  BlockGrid(BlockGrid&&) noexcept = default;
  BlockGrid& operator=(BlockGrid&&) noexcept = default;

  Value background() const { return nowhere_.tile; }
  /// Replaces each value, and the background value, by change(value).
  template <class Change>
  void transform(const Change& change) {
    nowhere_.tile = change(nowhere_.tile);
    for (auto& [key, node] : nodes_) {
      for (Block& block : *node) {
        block.tile = change(block.tile);
        if (block.leaf) std::ranges::transform(block.leaf->values, block.leaf->values.begin(), change);
      }
    }
  }

  /// Finds blocks by their keys (leaf_key()). Fast if successive blocks are near each other. One thread.
  class Reader {
   public:
    explicit Reader(const BlockGrid& grid) : grid_(grid) {}
    const Block& block(const glm::ivec3& key) {
      if (const glm::ivec3 node = key >> kNodeShift; node != near_) {
        const auto found = grid_.nodes_.find(node);
        near_ = node, node_ = found == grid_.nodes_.end() ? nullptr : found->second.get();
      }
      return node_ ? (*node_)[in_node(key)] : grid_.nowhere_;
    }
    Value value(const glm::ivec3& voxel) { return block(leaf_key(voxel)).value(Leaf::index(voxel)); }

   private:
    const BlockGrid& grid_;
    glm::ivec3 near_{kNoNode};
    const Node* node_ = nullptr;
  };
  const Block& block(const glm::ivec3& key) const {
    if (near_node_ && key >> kNodeShift == near_) return (*near_node_)[in_node(key)];
    return Reader(*this).block(key);
  }
  /// The block for writing. Creates its node if there is none. Only for the thread that writes.
  Block& block(const glm::ivec3& key) {
    if (const glm::ivec3 node = key >> kNodeShift; node != near_ || !near_node_) {
      std::unique_ptr<Node>& found = nodes_[node];
      if (!found) {
        found = std::make_unique<Node>();
        for (Block& block : *found) block.tile = background();
      }
      near_ = node, near_node_ = found.get();
    }
    return (*near_node_)[in_node(key)];
  }
  bool empty() const { return nodes_.empty(); }
  /// Number of nodes (16³ blocks), which need 64 kB each, besides their leaves.
  std::size_t nodes() const { return nodes_.size(); }
  /// Sets the value of a voxel and switches it on.
  void set(const glm::ivec3& voxel, Value value) { block(leaf_key(voxel)).set(Leaf::index(voxel), value); }

  /// Calls visit(key, block) for each block, except for tiles that equal the background. The order is FileOrder.
  template <class Visit>
  void for_each_block(Visit&& visit) const {
    each_block(*this, visit);
  }
  template <class Visit>
  void for_each_block(Visit&& visit) {
    each_block(*this, visit);
  }
  std::size_t leaf_count() const {
    std::size_t count = 0;
    for_each_block([&](const glm::ivec3&, const Block& block) { count += block.leaf != nullptr; });
    return count;
  }
  /// Turns each leaf whose voxels are all equal into a tile.
  void prune() {
    for_each_block([](const glm::ivec3&, Block& block) {
      if (!block.leaf) return;
      const auto same = [](const auto& all) { return std::ranges::all_of(all, [&](auto v) { return v == all[0]; }); };
      const Leaf& leaf = *block.leaf;
      if (!same(leaf.values) || !same(leaf.on) || (leaf.on[0] != 0 && ~leaf.on[0] != 0)) return;
      block = Block(leaf.values[0], leaf.on[0] != 0);
    });
  }
  /// Bounding box of all voxels that are on; may be empty.
  VoxelBox box_on() const {
    VoxelBox box;
    for_each_block([&](const glm::ivec3& key, const Block& block) {
      const glm::ivec3 first = key * kSide, last = first + kSide - 1;
      if (!block.leaf) {
        if (block.tile_on) extend(box, {first, last});
        return;
      }
      if (glm::all(glm::lessThanEqual(box.lo, first)) && glm::all(glm::lessThanEqual(last, box.hi))) return;
      for_each_voxel(glm::ivec3(kSide), [&](int x, int y, int z) {
        const glm::ivec3 at = first + glm::ivec3(x, y, z);
        if (block.leaf->is_on(Leaf::index(at))) extend(box, {at, at});
      });
    });
    return box;
  }

 private:
  /// Orders nodes as OpenVDB does: cubes of 32³ nodes by x, y, z, and inside a cube its nodes by x, y, z. The results
  /// of sums and hashes depend on this order.
  struct FileOrder {
    bool operator()(const glm::ivec3& a, const glm::ivec3& b) const {
      constexpr int cube = 5;
      const glm::ivec3 in_a = a >> cube, in_b = b >> cube;
      return in_a != in_b ? LessByAxes{}(in_a, in_b) : LessByAxes{}(a, b);
    }
  };

  static std::size_t in_node(const glm::ivec3& key) {
    constexpr int in = kNodeSide - 1;
    return static_cast<std::size_t>(((key.x & in) * kNodeSide + (key.y & in)) * kNodeSide + (key.z & in));
  }
  template <class Grid, class Visit>
  static void each_block(Grid& grid, Visit&& visit) {
    for (const auto& [at, node] : grid.nodes_) {
      std::size_t i = 0;
      for_each_voxel_between(at * kNodeSide, at * kNodeSide + kNodeSide - 1, [&](int x, int y, int z) {
        std::conditional_t<std::is_const_v<Grid>, const Block&, Block&> block = (*node)[i++];
        if (block.leaf || block.tile_on || block.tile != grid.background()) visit(glm::ivec3(x, y, z), block);
      });
    }
  }

  Block nowhere_;  // stands for each block without a node
  std::map<glm::ivec3, std::unique_ptr<Node>, FileOrder> nodes_;
  // the node in which the writer was last
  glm::ivec3 near_{kNoNode};
  Node* near_node_ = nullptr;
};

using DistanceGrid = BlockGrid<float>;
using LabelGrid = BlockGrid<std::int32_t>;

}  // namespace typodont::haptics
