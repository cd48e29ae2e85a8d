// Stores the changes that strokes make in an OpenVDB tree, leaf by leaf. Before a stroke writes to a leaf for the first
// time, the leaf is copied; undo and redo swap the copy and the leaf in the tree by pointer. Only for
// tissue_volume.cpp.
#pragma once

#include <openvdb/openvdb.h>

#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

namespace typodont::haptics {

template <class Tree>
class LeafHistory {
 public:
  using Leaf = typename Tree::LeafNodeType;
  using Value = typename Tree::ValueType;

  /// The leaf (8³ voxels) before the stroke, or the tile (one value for the whole leaf) that was at its position.
  struct Kept {
    std::unique_ptr<Leaf> leaf;  // copy of the leaf; null: a tile (one value for all voxels) was at this position
    Value tile{};
    bool tile_on = false;
    bool changed = false;  // true if the stroke wrote to the leaf; if not, the copy of the leaf is dropped
  };
  struct CoordHash {
    std::size_t operator()(const openvdb::Coord& c) const {
      return static_cast<std::size_t>(c.x()) * 73856093u ^ static_cast<std::size_t>(c.y()) * 19349663u ^
             static_cast<std::size_t>(c.z()) * 83492791u;
    }
  };
  using Stroke = std::unordered_map<openvdb::Coord, Kept, CoordHash>;

  /// Must be called before the leaf at `origin` is written or created; the caller then sets `changed`.
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

  /// Swaps the stroke's copies of leaves (8³ voxels) with the tree's leaves. Undo and redo use the same operation.
  static void exchange(Tree& tree, Stroke& stroke) {
    for (auto& [origin, kept] : stroke) {
      std::unique_ptr<Leaf> there(tree.template stealNode<Leaf>(origin, kept.tile, kept.tile_on));
      if (kept.leaf) tree.addLeaf(kept.leaf.release());
      kept.leaf = std::move(there);
    }
  }

  /// The values of the voxels of one leaf (8³ voxels).
  struct Values {
    // values of the leaf's voxels; null: no leaf existed at this position, and all its voxels had one value, that of a
    // tile
    const Value* samples = nullptr;
    Value tile{};
  };
  static Values there(const Tree& tree, const openvdb::Coord& origin) {
    const Leaf* leaf = tree.probeConstLeaf(origin);
    return leaf ? Values{leaf->buffer().data(), {}} : Values{nullptr, tree.getValue(origin)};
  }
  /// Returns the values of the leaf (8³ voxels) at `origin` before the stroke; nullopt if it was not written to.
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
