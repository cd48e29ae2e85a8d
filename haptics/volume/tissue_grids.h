// The tissue's grids, and the strokes in which they were edited. Private to haptics/volume: whoever includes it
// compiles OpenVDB.
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

/// A box of bricks, inclusive.
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
/// All bricks that read any of the samples in the inclusive box: a brick reads one sample beyond its cells on each
/// side.
BrickBox bricks_around(const glm::ivec3& lo, const glm::ivec3& hi);
void insert_bricks(const glm::ivec3& lo, const glm::ivec3& hi, KeySet& keys);

// A value of the grid of labels holds the label (label.h) in its lowest byte and 255 − hardness (hardness.h) in the
// next. So a tissue of its own hardness has the values that it had before there was any hardness, and undo, tiles and
// hashes cover both.
inline constexpr int kSoftnessShift = 8;
inline constexpr std::int32_t kLabelByte = 0xff;

inline std::int32_t grid_value(Tissue label, std::uint8_t hardness) {
  return static_cast<std::int32_t>(label) | (kOwnHardness - hardness) << kSoftnessShift;
}
inline Tissue label_in(std::int32_t value) {
  return static_cast<Tissue>(value & kLabelByte);
}
/// Of a filled voxel: of what was there before the filling.
inline std::uint8_t hardness_kept_in(std::int32_t value) {
  return static_cast<std::uint8_t>(kOwnHardness - (value >> kSoftnessShift));
}
/// The hardness that is felt and cut.
inline std::uint8_t hardness_in(std::int32_t value) {
  return is_filled(label_in(value)) ? kOwnHardness : hardness_kept_in(value);
}
/// Another label with the same hardness.
inline std::int32_t relabelled(std::int32_t value, Tissue label) {
  return (value & ~kLabelByte) | static_cast<std::int32_t>(label);
}
/// What a value of the grid of labels shows.
inline Tissue shown_in(std::int32_t value) {
  return shown(label_in(value));
}

/// All that one stroke changed, as it was before; once undone, as it was after.
struct StrokeKept {
  using Distance = LeafHistory<openvdb::FloatTree>;
  using Labels = LeafHistory<openvdb::Int32Tree>;
  Distance::Stroke distance;
  Labels::Stroke tissue;
  std::vector<glm::ivec3> carved;  // bricks first cut by this stroke
  // Once it is complete:
  std::vector<glm::ivec3> bricks;  // that are others when it is undone or brought again
  PerTissue back{};                // m³ that come back when it is undone
  std::size_t bytes = 0;
};

struct TissueVolume::Impl {
  openvdb::FloatGrid::Ptr distance;  // voxels
  openvdb::Int32Grid::Ptr tissue;    // labels and hardness, see grid_value()
  std::uint64_t paints = 0;          // calls of paint()
  bool graded = false;               // some voxel was given a hardness other than its tissue's own
  VoxelFrame frame;
  double band = 0;  // m
  bool exact_outside = true;
  std::shared_ptr<const TissueMesh> mesh;  // that the volume was made from, or null
  KeySet changed;                          // bricks since take_changed_bricks
  KeySet carved;                           // bricks ever cut: distances outside the tissue are no longer true there
  // The last bricks that a cut inserted into `changed` and `carved`, inclusive; lo > hi: none that are still there.
  glm::ivec3 marked_lo{0}, marked_hi{-1};
  LeafFront front;  // of the head that cuts
  KeySet filled;    // leaves, counted in leaves, that may hold labels of a filling: see label.h
  // What was written since each of the last marks, oldest first; the last is `marked`. Empty: nothing is known of what
  // was before `marked`.
  std::deque<TissueVolume::Written> writes;
  std::uint64_t marked = first_mark();
  std::vector<StrokeKept> strokes;
  std::size_t done = 0;    // strokes in the tissue; those after it were undone
  bool in_stroke = false;  // the last one is still being made
  PerTissue taken_back{};  // m³ that came back by undoing, less what went again

  Impl() { openvdb::initialize(); }
  void make_grids(float band_voxels) {
    distance = openvdb::FloatGrid::create(band_voxels);
    tissue = openvdb::Int32Grid::create(0);
  }

  /// Marks of different volumes differ.
  static std::uint64_t first_mark();
  /// Something changed of which no log is kept.
  void forget_writes();

  StrokeKept* stroke() { return in_stroke ? &strokes.back() : nullptr; }

  openvdb::FloatTree::LeafNodeType* leaf_to_cut(openvdb::FloatGrid::Accessor& accessor, const openvdb::Coord& origin,
                                                LeafFront::Kept*& kept);
  void leaf_was_cut(openvdb::FloatTree::LeafNodeType& leaf, LeafFront::Kept* kept);
  /// A leaf was written to.
  void log_write(const glm::ivec3& key);

  /// Drops leaves that were looked at only, and a stroke that changed nothing.
  void complete_stroke();

  /// Bricks of a box that a cut or a filling has written to; lo > hi: it wrote nothing.
  void mark_changed(const glm::ivec3& lo, const glm::ivec3& hi);

  /// See TissueVolume; of the samples between two, inclusive.
  void copy_every(int n, const Copied& box, const glm::ivec3& from, const glm::ivec3& to) const;

  // The parts of labels, which files keep apart: see StoredVolume. Hardness is taken first and put last.
  openvdb::Int32Grid::Ptr take_before(openvdb::Int32Grid& labels) const;
  void put_before(const openvdb::Int32Grid& before);
  openvdb::Int32Grid::Ptr take_hardness(openvdb::Int32Grid& labels) const;
  void put_hardness(const openvdb::Int32Grid& hardness);

  /// Where distances changed in that box: labels of fillings that are no longer there go.
  void restore_labels(const TissueVolume& self, glm::ivec3 lo, glm::ivec3 hi);

  /// What a stroke changed, for what is there now.
  void exchange(StrokeKept& stroke, bool back);
};

}  // namespace typodont::haptics
