// Undo leaf by leaf: a leaf is copied before the first write of a stroke; undo and redo exchange pointers. For
// tissue_volume.cpp only.
#pragma once

#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "haptics/volume/openvdb.h"

namespace typodont::haptics {

template <class Tree>
class LeafHistory {
 public:
  using Leaf = typename Tree::LeafNodeType;
  using Value = typename Tree::ValueType;

  /// State of a leaf (8³ voxels) or tile (one value for a region) before the stroke.
  struct Kept {
    std::unique_ptr<Leaf> leaf;  // null: a tile
    Value tile{};
    bool tile_on = false;
    bool changed = false;  // true: the stroke changed the leaf; otherwise the copy is deleted at the stroke's end
  };
  struct CoordHash {
    std::size_t operator()(const openvdb::Coord& c) const {
      return static_cast<std::size_t>(c.x()) * 73856093u ^ static_cast<std::size_t>(c.y()) * 19349663u ^
             static_cast<std::size_t>(c.z()) * 83492791u;
    }
  };
  using Stroke = std::unordered_map<openvdb::Coord, Kept, CoordHash>;

  /// Stores the state before a leaf is written or created. The caller then sets `changed`.
  template <class Accessor>
  static Kept& keep(Stroke& stroke, Accessor& accessor, const openvdb::Coord& origin) {
    const auto [it, fresh] = stroke.try_emplace(origin);
    if (!fresh) return it->second;
    Kept& kept = it->second;
    if (const Leaf* leaf = accessor.probeConstLeaf(origin)) {
      kept.leaf = std::make_unique<Leaf>(*leaf);
    } else {
      kept.tile_on = accessor.probeValue(origin, kept.tile);
    }
    return kept;
  }

  /// Exchanges current and stored leaves, for undo and redo.
  static void exchange(Tree& tree, Stroke& stroke) {
    for (auto& [origin, kept] : stroke) {
      std::unique_ptr<Leaf> there(tree.template stealNode<Leaf>(origin, kept.tile, kept.tile_on));
      if (kept.leaf) tree.addLeaf(kept.leaf.release());
      kept.leaf = std::move(there);
    }
  }

  /// The values of the voxels of one leaf (8³ voxels).
  struct Values {
    // null: all voxels have one value
    const Value* samples = nullptr;
    Value tile{};
  };
  static Values there(const Tree& tree, const openvdb::Coord& origin) {
    const Leaf* leaf = tree.probeConstLeaf(origin);
    return leaf ? Values{leaf->buffer().data(), {}} : Values{nullptr, tree.getValue(origin)};
  }
  /// Values before the stroke; nullopt: the stroke has not written this leaf.
  static std::optional<Values> before(const Stroke& stroke, const openvdb::Coord& origin) {
    const auto it = stroke.find(origin);
    if (it == stroke.end()) return std::nullopt;
    const Kept& kept = it->second;
    return kept.leaf ? Values{kept.leaf->buffer().data(), {}} : Values{nullptr, kept.tile};
  }

  static std::size_t bytes(const Stroke& stroke) {
    std::size_t sum = sizeof(Stroke);
    for (const auto& [origin, kept] : stroke)
      sum += sizeof(origin) + sizeof(kept) + 16 + (kept.leaf ? kept.leaf->memUsage() : 0);
    return sum;
  }
};

}  // namespace typodont::haptics
