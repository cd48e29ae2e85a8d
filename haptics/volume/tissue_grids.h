// Grids and strokes. Private to haptics/volume: includes OpenVDB.
#pragma once

#include <openvdb/openvdb.h>

#include <climits>
#include <deque>
#include <unordered_set>
#include <vector>

#include "haptics/tissue_volume.h"
#include "haptics/volume/label.h"
#include "haptics/volume/leaf_front.h"
#include "haptics/volume/leaf_history.h"

namespace typodont::haptics {

struct KeyHash {
  std::size_t operator()(const glm::ivec3& k) const {
    return static_cast<std::size_t>(k.x) * 73856093u ^ static_cast<std::size_t>(k.y) * 19349663u ^
           static_cast<std::size_t>(k.z) * 83492791u;
  }
};
using KeySet = std::unordered_set<glm::ivec3, KeyHash>;

inline openvdb::Coord coord(const glm::ivec3& v) {
  return {v.x, v.y, v.z};
}
inline glm::ivec3 vec(const openvdb::Coord& c) {
  return {c.x(), c.y(), c.z()};
}
inline int floor_div(int a, int b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

/// Of bricks, inclusive (FieldBrick).
struct BrickBox {
  glm::ivec3 lo, hi;
  template <class F>
  void for_each(F&& visit) const {
    for (int x = lo.x; x <= hi.x; ++x) {
      for (int y = lo.y; y <= hi.y; ++y) {
        for (int z = lo.z; z <= hi.z; ++z) visit(glm::ivec3(x, y, z));
      }
    }
  }
};
/// That read a sample of lo .. hi inclusive, each one beyond its cells.
BrickBox bricks_around(const glm::ivec3& lo, const glm::ivec3& hi);
void insert_bricks(const glm::ivec3& lo, const glm::ivec3& hi, KeySet& keys);

// Label (label.h), and 255 − hardness (dense_tissue.h) in the next byte: equal to the label at kOwnHardness. Undo,
// tiles and hashes so include hardness.
inline constexpr int kSoftnessShift = 8;
inline constexpr std::int32_t kLabelByte = 0xff;

inline std::int32_t grid_value(Tissue label, std::uint8_t hardness) {
  return static_cast<std::int32_t>(label) | (kOwnHardness - hardness) << kSoftnessShift;
}
inline Tissue label_in(std::int32_t value) {
  return static_cast<Tissue>(value & kLabelByte);
}
/// Filled: before the filling.
inline std::uint8_t hardness_kept_in(std::int32_t value) {
  return static_cast<std::uint8_t>(kOwnHardness - (value >> kSoftnessShift));
}
/// That is felt and cut.
inline std::uint8_t hardness_in(std::int32_t value) {
  return is_filled(label_in(value)) ? kOwnHardness : hardness_kept_in(value);
}
/// Same hardness.
inline std::int32_t relabelled(std::int32_t value, Tissue label) {
  return (value & ~kLabelByte) | static_cast<std::int32_t>(label);
}
/// Returns the tissue that a voxel with this value of the label grid shows.
inline Tissue shown_in(std::int32_t value) {
  return shown(label_in(value));
}

/// Of 8³ distances.
SolidBits solid_bits(const float* samples);

/// Leaves from before the stroke; after its undo, from after it.
struct StrokeKept {
  using Distance = LeafHistory<openvdb::FloatTree>;
  using Labels = LeafHistory<openvdb::Int32Tree>;
  Distance::Stroke distance;
  Labels::Stroke tissue;
  std::vector<glm::ivec3> carved;  // first cut by this stroke
  // Once complete: bricks that undo and redo change
  std::vector<glm::ivec3> bricks;
  PerTissue back{};  // m³ that undo brings back
  std::size_t bytes = 0;
};

struct TissueVolume::Impl {
  openvdb::FloatGrid::Ptr distance;  // distances in voxels
  openvdb::Int32Grid::Ptr tissue;    // labels and hardness, see grid_value()
  std::uint64_t paints = 0;          // number of calls of paint() that changed tissue
  bool graded = false;               // some voxel is off its tissue's own
  VoxelFrame frame;
  double band = 0;  // m from the surface, of stored distances
  bool exact_outside = true;
  FilePlace place;
  std::shared_ptr<const TissueMesh> mesh;  // null: from other data
  std::shared_ptr<const NaturalSurface> natural;
  KeySet changed;  // since the last take_changed_bricks()
  // cut: outside distances are inexact there
  KeySet carved;
  // Last box put into `changed` and `carved`, inclusive; empty (lo > hi) at first and after removals from them.
  glm::ivec3 marked_lo{0}, marked_hi{-1};
  LeafFront front;  // that the present head can change
  // Of the present cut; due_places: what `front` keeps for each.
  std::vector<Sweep::Leaf> due_leaves;
  std::vector<const LeafFront::DuePlace*> due_places;
  KeySet filled;  // may hold labels under filling, label.h
  // After each of the last marks, oldest first; last is `marked`. Empty: unknown before it.
  std::deque<Written> writes;
  std::uint64_t marked = first_mark();
  std::uint64_t foreign_changes = 0;  // see TissueVolume::foreign_changes()
  std::vector<StrokeKept> strokes;
  std::size_t done = 0;    // in the tissue; later ones are undone
  bool in_stroke = false;  // not complete yet
  PerTissue taken_back{};  // m³ by undo, minus redo

  Impl() { openvdb::initialize(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  /// Allocates nothing, so it works without memory.
  ~Impl();
  void make_grids(float band_voxels) {
    distance = openvdb::FloatGrid::create(band_voxels);
    tissue = openvdb::Int32Grid::create(0);
  }

  /// Where a new volume's log begins; different volumes differ.
  static std::uint64_t first_mark();
  /// At a change that is not logged, which is foreign (TissueVolume::foreign_changes).
  void forget_writes();

  StrokeKept* stroke() { return in_stroke ? &strokes.back() : nullptr; }

  openvdb::FloatTree::LeafNodeType* leaf_to_cut(openvdb::FloatGrid::Accessor& accessor, const openvdb::Coord& origin,
                                                LeafFront::Kept*& kept);
  void leaf_was_cut(openvdb::FloatTree::LeafNodeType& leaf, LeafFront::Kept* kept);
  /// And a stroke that changed nothing.
  void complete_stroke();

  /// Of lo..hi, by cut or filling; lo > hi: none. `listed`: log_write() was called for all.
  void mark_changed(const glm::ivec3& lo, const glm::ivec3& hi, bool listed);
  /// Unless it is there. `lo`: first voxel.
  void log_write(const glm::ivec3& lo, LeafFront::Place& place);

  /// As TissueVolume::copy_every(), samples from..to inclusive.
  void copy_every(int n, const Copied& box, const glm::ivec3& from, const glm::ivec3& to) const;

  /// Of both grids.
  struct LeafSource {
    glm::ivec3 lo;                                      // position of its first voxel
    const openvdb::FloatTree::LeafNodeType* distances;  // null: all samples have the value `distance`
    const openvdb::Int32Tree::LeafNodeType* labels;     // null: all samples have the value `label`
    float distance;
    std::int32_t label;
  };
  class LeafFinder;
  /// `part`: whole leaves.
  std::vector<LeafSource> leaves_in(const VoxelBox& part) const;
  void copy_whole_leaves(const Copied& box, const std::vector<LeafSource>& sources) const;

  // Files have label, hardness and label before filling apart (StoredVolume): split on saving, joined on loading.
  openvdb::Int32Grid::Ptr take_before(openvdb::Int32Grid& labels) const;
  void put_before(const openvdb::Int32Grid& before);
  openvdb::Int32Grid::Ptr take_hardness(openvdb::Int32Grid& labels) const;
  void put_hardness(const openvdb::Int32Grid& hardness);

  /// After distances changed and filling went: its former labels return.
  void restore_labels(const TissueVolume& self, glm::ivec3 lo, glm::ivec3 hi);

  /// `back`: undo.
  void exchange(StrokeKept& stroke, bool back);
};

}  // namespace typodont::haptics
