// Undo leaf by leaf: a block is copied before the first write of a stroke; undo and redo exchange blocks. Private to
// haptics/volume.
#pragma once

#include <unordered_map>
#include <utility>

#include "engine/base/voxels.h"
#include "haptics/volume/block_grid.h"

namespace typodont::haptics {

template <class Value>
class LeafHistory {
 public:
  using Grid = BlockGrid<Value>;

  struct Kept {
    typename Grid::Block block;  // the block as it was before the stroke
    bool changed = false;  // true: the stroke changed the block; otherwise the copy is deleted at the stroke's end
  };
  using Stroke = std::unordered_map<glm::ivec3, Kept, KeyHash>;  // by the blocks' keys

  /// Stores a block before it is written. The caller then sets `changed`.
  static Kept& keep(Stroke& stroke, const glm::ivec3& key, const typename Grid::Block& block) {
    const auto [it, fresh] = stroke.try_emplace(key);
    if (fresh) it->second.block = typename Grid::Block(block);
    return it->second;
  }

  /// Exchanges current and stored blocks, for undo and redo.
  static void exchange(Grid& grid, Stroke& stroke) {
    for (auto& [key, kept] : stroke) std::swap(grid.block(key), kept.block);
  }

  /// Returns the block before the stroke; null: the stroke has not written it.
  static const typename Grid::Block* before(const Stroke& stroke, const glm::ivec3& key) {
    const auto it = stroke.find(key);
    return it == stroke.end() ? nullptr : &it->second.block;
  }

  static std::size_t bytes(const Stroke& stroke) {
    std::size_t sum = sizeof(Stroke);
    for (const auto& [key, kept] : stroke)
      sum += sizeof(key) + sizeof(kept) + 16 + (kept.block.leaf ? sizeof(typename Grid::Leaf) : 0);
    return sum;
  }
};

}  // namespace typodont::haptics
