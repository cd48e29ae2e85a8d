// The grids of the tissue, and the strokes that edited them. Private to haptics/volume: this header includes OpenVDB.
#pragma once

#include <openvdb/openvdb.h>

#include <climits>
#include <deque>
#include <unordered_set>
#include <vector>

#include "haptics/label.h"
#include "haptics/tissue_volume.h"
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

/// A box of bricks (cubes of 16³ cells that are drawn as one, see FieldBrick); both corners are included.
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
/// Returns all bricks (blocks that are drawn as one) that read a sample in the box lo .. hi, inclusive. A brick reads
/// one sample beyond its cells on each side.
BrickBox bricks_around(const glm::ivec3& lo, const glm::ivec3& hi);
void insert_bricks(const glm::ivec3& lo, const glm::ivec3& hi, KeySet& keys);

// A value of the label grid contains the label (label.h) in its lowest byte and 255 − hardness (hardness.h) in the next
// byte. So in a tissue with the default hardness kOwnHardness (255), the upper byte is 0 and the value equals the
// label. Undo, tiles and hashes use these values, so they include the hardness without additional code.
inline constexpr int kSoftnessShift = 8;
inline constexpr std::int32_t kLabelByte = 0xff;

inline std::int32_t grid_value(Tissue label, std::uint8_t hardness) {
  return static_cast<std::int32_t>(label) | (kOwnHardness - hardness) << kSoftnessShift;
}
inline Tissue label_in(std::int32_t value) {
  return static_cast<Tissue>(value & kLabelByte);
}
/// Returns the hardness stored in a value; for a filled voxel this is the hardness before the filling.
inline std::uint8_t hardness_kept_in(std::int32_t value) {
  return static_cast<std::uint8_t>(kOwnHardness - (value >> kSoftnessShift));
}
/// Returns the hardness that the hand feels and that determines cutting.
inline std::uint8_t hardness_in(std::int32_t value) {
  return is_filled(label_in(value)) ? kOwnHardness : hardness_kept_in(value);
}
/// Returns the value with another label and the same hardness.
inline std::int32_t relabelled(std::int32_t value, Tissue label) {
  return (value & ~kLabelByte) | static_cast<std::int32_t>(label);
}
/// Returns the tissue that a voxel with this value of the label grid shows.
inline Tissue shown_in(std::int32_t value) {
  return shown(label_in(value));
}

/// Determines which samples of a leaf (8³ distances) are inside tissue.
SolidBits solid_bits(const float* samples);

/// All changes of one stroke, as copies of leaves (8³ voxels) from before the stroke. After an undo of the stroke, they
/// are copies of the leaves from after the stroke.
struct StrokeKept {
  using Distance = LeafHistory<openvdb::FloatTree>;
  using Labels = LeafHistory<openvdb::Int32Tree>;
  Distance::Stroke distance;
  Labels::Stroke tissue;
  std::vector<glm::ivec3> carved;  // bricks (blocks that are drawn as one) that this stroke was the first to cut
  // The next members are valid after the stroke is complete.
  // bricks (blocks that are drawn as one) that change when the stroke is undone or redone
  std::vector<glm::ivec3> bricks;
  PerTissue back{};  // m³, volume that comes back when the stroke is undone
  std::size_t bytes = 0;
};

struct TissueVolume::Impl {
  openvdb::FloatGrid::Ptr distance;  // distances in voxels
  openvdb::Int32Grid::Ptr tissue;    // labels and hardness, see grid_value()
  std::uint64_t paints = 0;          // number of calls of paint() that changed tissue
  bool graded = false;               // true if some voxel has a hardness other than its tissue's own
  VoxelFrame frame;
  double band = 0;  // m, distance from the surface up to which distances are stored
  bool exact_outside = true;
  FilePlace place;
  std::shared_ptr<const TissueMesh> mesh;  // mesh from which the volume was made; null: made from other data
  std::shared_ptr<const NaturalSurface> natural;
  KeySet changed;  // bricks (blocks that are drawn as one) that changed since the last take_changed_bricks()
  // bricks (blocks that are drawn as one) that were cut; outside the tissue, the distances in them are no longer exact
  KeySet carved;
  // The last box of bricks (blocks that are drawn as one) that a cut inserted into the sets `changed` and `carved`,
  // inclusive. Empty (lo > hi) at first, and after bricks were removed from these sets.
  glm::ivec3 marked_lo{0}, marked_hi{-1};
  LeafFront front;  // leaves (8³ voxels) that the next cuts of the present head can change
  // The leaves (8³ voxels) that the present cut examines. The entry of due_places with the same index points to the
  // data that `front` stores for the leaf.
  std::vector<Sweep::Leaf> due_leaves;
  std::vector<const LeafFront::DuePlace*> due_places;
  KeySet filled;  // keys of leaves (8³ voxels) that may contain labels of a filling, see label.h
  // The writes after each of the last marks (numbers of states, TissueVolume::mark), oldest first; the last mark is
  // `marked`. Empty: the writes before `marked` are unknown.
  std::deque<Written> writes;
  std::uint64_t marked = first_mark();
  std::uint64_t foreign_changes = 0;  // see TissueVolume::foreign_changes()
  std::vector<StrokeKept> strokes;
  std::size_t done = 0;    // number of strokes that are in the tissue; later strokes were undone
  bool in_stroke = false;  // true if the last stroke is not complete yet
  PerTissue taken_back{};  // m³, volume that all undos brought back, minus what redos removed again

  Impl() { openvdb::initialize(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  /// Allocates no memory, so the volume can also be destroyed after memory has run out.
  ~Impl();
  void make_grids(float band_voxels) {
    distance = openvdb::FloatGrid::create(band_voxels);
    tissue = openvdb::Int32Grid::create(0);
  }

  /// Returns the mark (number of a state) with which the log of a new volume begins. Marks of different volumes differ.
  static std::uint64_t first_mark();
  /// Discards the log of writes. Must be called at a change of the tissue that is not logged. Such a change also is a
  /// foreign change (TissueVolume::foreign_changes).
  void forget_writes();

  StrokeKept* stroke() { return in_stroke ? &strokes.back() : nullptr; }

  openvdb::FloatTree::LeafNodeType* leaf_to_cut(openvdb::FloatGrid::Accessor& accessor, const openvdb::Coord& origin,
                                                LeafFront::Kept*& kept);
  void leaf_was_cut(openvdb::FloatTree::LeafNodeType& leaf, LeafFront::Kept* kept);
  /// Drops copies of leaves (8³ voxels) that were not written to, and a stroke that changed nothing.
  void complete_stroke();

  /// Adds to `changed` and `carved` the bricks (blocks that are drawn as one) of the box lo..hi that a cut or a filling
  /// has changed. If lo > hi, adds none. `listed`: true if log_write() was called for all changed leaves.
  void mark_changed(const glm::ivec3& lo, const glm::ivec3& hi, bool listed);
  /// Adds a leaf to the list of the leaves with writes, unless it is already in it. `lo`: its first voxel.
  void log_write(const glm::ivec3& lo, LeafFront::Place& place);

  /// Copies every n-th sample as TissueVolume::copy_every() does, but only the samples from..to, inclusive.
  void copy_every(int n, const Copied& box, const glm::ivec3& from, const glm::ivec3& to) const;

  /// A leaf (8³ voxels) of both grids, from which samples are copied.
  struct LeafSource {
    glm::ivec3 lo;                                      // position of its first voxel
    const openvdb::FloatTree::LeafNodeType* distances;  // null: all samples have the value `distance`
    const openvdb::Int32Tree::LeafNodeType* labels;     // null: all samples have the value `label`
    float distance;
    std::int32_t label;
  };
  class LeafFinder;
  /// Returns the leaves of `part`, which consists of whole leaves.
  std::vector<LeafSource> leaves_in(const VoxelBox& part) const;
  void copy_whole_leaves(const Copied& box, const std::vector<LeafSource>& sources) const;

  // A file stores label, hardness and the label before a filling in separate grids (StoredVolume). Saving extracts the
  // hardness first; loading inserts it last.
  openvdb::Int32Grid::Ptr take_before(openvdb::Int32Grid& labels) const;
  void put_before(const openvdb::Int32Grid& before);
  openvdb::Int32Grid::Ptr take_hardness(openvdb::Int32Grid& labels) const;
  void put_hardness(const openvdb::Int32Grid& hardness);

  /// Must be called after distances in a box changed and a filling was removed there. Gives the voxels of the removed
  /// filling the labels that they had before the filling.
  void restore_labels(const TissueVolume& self, glm::ivec3 lo, glm::ivec3 hi);

  /// Swaps the content of a stroke with the tissue; `back`: true for undo.
  void exchange(StrokeKept& stroke, bool back);
};

}  // namespace typodont::haptics
