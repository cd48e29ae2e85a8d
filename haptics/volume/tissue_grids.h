// The grids and strokes of a volume. Private to haptics/volume.
#pragma once

#include <climits>
#include <deque>
#include <optional>
#include <unordered_set>
#include <utility>
#include <vector>

#include "engine/base/voxels.h"
#include "haptics/tissue_volume.h"
#include "haptics/volume/block_grid.h"
#include "haptics/volume/label.h"
#include "haptics/volume/leaf_front.h"
#include "haptics/volume/leaf_history.h"

namespace typodont::haptics {

using KeySet = std::unordered_set<glm::ivec3, KeyHash>;

inline int floor_div(int a, int b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

/// A box of bricks (FieldBrick), inclusive.
struct BrickBox {
  glm::ivec3 lo, hi;
  template <class F>
  void for_each(F&& visit) const {
    for_each_voxel_between(lo, hi, visit);
  }
};
/// Bricks that read a sample in lo .. hi (inclusive); a brick reads one sample beyond its cells.
BrickBox bricks_around(const glm::ivec3& lo, const glm::ivec3& hi);
void insert_bricks(const glm::ivec3& lo, const glm::ivec3& hi, KeySet& keys);

// Value of the label grid: label (label.h), 255 − hardness (dense_tissue.h) in the next byte, and VoxelColor in the two
// highest bytes. At kOwnHardness and kTissueColor, the value equals the label. Undo, tiles and hashes include all
// parts.
inline constexpr int kSoftnessShift = 8, kColorShift = 16;
inline constexpr std::int32_t kLabelByte = 0xff;

inline std::int32_t grid_value(Tissue label, std::uint8_t hardness, VoxelColor color) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(color) << kColorShift) |
         (kOwnHardness - hardness) << kSoftnessShift | static_cast<std::int32_t>(label);
}
inline Tissue label_in(std::int32_t value) {
  return static_cast<Tissue>(value & kLabelByte);
}
/// Hardness of the voxel; of a filled voxel, the hardness before the filling.
inline std::uint8_t hardness_kept_in(std::int32_t value) {
  return static_cast<std::uint8_t>(kOwnHardness - (value >> kSoftnessShift));
}
/// Hardness with which the voxel is felt and cut; filling has its own hardness.
inline std::uint8_t hardness_in(std::int32_t value) {
  return is_filled(label_in(value)) ? kOwnHardness : hardness_kept_in(value);
}
/// Colour of the voxel; of a filled voxel, the colour before the filling.
inline VoxelColor color_kept_in(std::int32_t value) {
  return static_cast<VoxelColor>(static_cast<std::uint32_t>(value) >> kColorShift);
}
/// Colour in which the voxel is drawn; a filled voxel has the colour of the filling's material.
inline VoxelColor color_in(std::int32_t value) {
  return is_filled(label_in(value)) ? kTissueColor : color_kept_in(value);
}
/// Changes the label and keeps hardness and colour.
inline std::int32_t relabelled(std::int32_t value, Tissue label) {
  return (value & ~kLabelByte) | static_cast<std::int32_t>(label);
}
/// Visible tissue of a voxel with this value in the label grid; the filling if the voxel is filled.
inline Tissue shown_in(std::int32_t value) {
  return shown(label_in(value));
}

/// Bit mask of the samples in tissue among 8³ distances.
SolidBits solid_bits(const float* samples);

/// The grids' leaves (8³ voxels) as they were before a stroke; while the stroke is undone, as they were after it.
struct StrokeKept {
  using Distance = LeafHistory<float>;
  using Labels = LeafHistory<std::int32_t>;
  Distance::Stroke distance;
  Labels::Stroke tissue;
  std::vector<glm::ivec3> carved;  // bricks that this stroke was the first to cut
  // bricks that undo and redo of this stroke change; set when the stroke is complete
  std::vector<glm::ivec3> bricks;
  PerTissue back{};  // m³, volume of each tissue that undo restores
  std::size_t bytes = 0;
};

struct TissueVolume::Impl {
  DistanceGrid distance;     // voxels
  LabelGrid tissue;          // labels, hardness and colours, see grid_value()
  std::uint64_t paints = 0;  // number of calls of paint() that changed tissue
  bool graded = false;       // true: some voxels' hardness differs from their tissue's
  bool colored = false;      // true: some voxels' colour differs from their tissue's
  VoxelFrame frame;
  double band = 0;  // m, largest distance from the surface that is stored
  bool exact_outside = true;
  FilePlace place;
  std::shared_ptr<const TissueMesh> mesh;  // mesh from which the volume was made; null: none
  std::shared_ptr<const NaturalSurface> natural;
  KeySet changed;  // bricks that changed since the last take_changed_bricks()
  // bricks that were cut; outside tissue, their distances are inexact
  KeySet carved;
  // Last box of bricks that was added to `changed` and `carved`, inclusive; empty (lo > hi) at first and after elements
  // were removed.
  glm::ivec3 marked_lo{0}, marked_hi{-1};
  LeafFront front;  // leaves that the current head can change
  // Leaves of the current cut. due_places: for each of these leaves, its data in `front`.
  std::vector<Sweep::Leaf> due_leaves;
  std::vector<const LeafFront::DuePlace*> due_places;
  KeySet filled;  // leaves that may contain filled voxels (label.h)
  // For each of the last calls of TissueVolume::mark(), oldest first: what was written between this call and the next.
  // The last element has the writes since `marked`. Empty: earlier writes are not known.
  std::deque<Written> writes;
  std::uint64_t marked = first_mark();
  std::uint64_t foreign_changes = 0;  // changes that the servo does not make in its patch itself
  std::vector<StrokeKept> strokes;
  std::size_t done = 0;    // number of strokes in the tissue; later strokes are undone
  bool in_stroke = false;  // true: the last stroke is not complete yet
  PerTissue taken_back{};  // m³ that undos restored, minus what redos removed again

  Impl(DistanceGrid distances, LabelGrid labels) : distance(std::move(distances)), tissue(std::move(labels)) {}
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// First number for the marks of a new volume (TissueVolume::mark()); differs between volumes.
  static std::uint64_t first_mark();
  /// Discards `writes`, because a change was made that log_write() does not record (TissueVolume::foreign_changes).
  void forget_writes();

  StrokeKept* stroke() { return in_stroke ? &strokes.back() : nullptr; }

  LeafFront::Leaf* leaf_to_cut(const glm::ivec3& key, LeafFront::Kept*& kept);
  void leaf_was_cut(LeafFront::Leaf& leaf, LeafFront::Kept* kept);
  /// Ends the stroke, and drops it if it changed nothing.
  void complete_stroke();

  /// Marks voxels lo..hi as changed by cut or filling; lo > hi: none. `listed`: log_write() has logged all leaves.
  void mark_changed(const glm::ivec3& lo, const glm::ivec3& hi, bool listed);
  /// Adds a leaf to the list of written leaves (`writes`), unless already listed. `lo`: its first voxel.
  void log_write(const glm::ivec3& lo, LeafFront::Place& leaf);

  /// Copies every n-th sample (see TissueVolume::copy_every()), but only samples from..to (inclusive).
  void copy_every(int n, const Copied& box, const glm::ivec3& from, const glm::ivec3& to) const;

  /// A leaf's distances and labels.
  struct LeafSource {
    glm::ivec3 lo;  // voxels, position of the first voxel
    const DistanceGrid::Block* distances;
    const LabelGrid::Block* labels;
  };
  class LeafFinder;
  /// Returns the leaves of `part`, a box that consists of whole leaves (8³ voxels).
  std::vector<LeafSource> leaves_in(const VoxelBox& part) const;
  void copy_whole_leaves(const Copied& box, const std::vector<LeafSource>& sources) const;

  // Files store label, hardness, colour and the label before filling separately (StoredVolume): the label grid is split
  // on saving and joined on loading.
  std::optional<LabelGrid> take_before(LabelGrid& labels) const;
  void put_before(const LabelGrid& before);
  /// Part of the label grid's values that a file stores as a grid of its own.
  struct Part {
    std::int32_t usual;                                     // background of the file's grid
    std::int32_t (*get)(std::int32_t value);                // value in the file
    std::int32_t (*set)(std::int32_t value, std::int32_t);  // `value` with this part set to the second argument
  };
  static const Part kHardnessPart, kColorPart;
  /// Moves a part of the labels to a grid of its own; nullopt if all voxels have the value Part::usual.
  static std::optional<LabelGrid> take(const Part& part, LabelGrid& labels);
  /// Adds a part from its own grid to the labels. Returns true if a voxel's value differs from the part's `usual`.
  bool put(const Part& part, const LabelGrid& values);

  /// Restores former labels where a filling was removed. Call it after distances have changed.
  void restore_labels(const TissueVolume& self, glm::ivec3 lo, glm::ivec3 hi);

  /// `back`: true for undo, false for redo.
  void exchange(StrokeKept& stroke, bool back);
};

}  // namespace typodont::haptics
