// The tissue: a sparse signed distance field with a label per voxel.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/contact/patch_step.h"
#include "haptics/dense_tissue.h"
#include "haptics/fill.h"
#include "haptics/sweep.h"
#include "haptics/volume/loose_pieces.h"

namespace typodont::haptics {

class NaturalSurface;
class Solid;
class PlacedHead;
class VoxelStamp;
struct TissueMesh;

/// Samples of a field from voxel lo to lo+size-1; z runs fastest.
struct RasterBlock {
  glm::ivec3 lo, size;
  std::vector<float> distance;
};

/// Owns the tissue, which is a sparse distance field. Used by one thread at a time; in a session, this is the carver
/// thread. Set-up functions throw Error.
///
/// File format (.vdb): grids "distance" (float, mm, level set, background = band) and "tissue" (int32 labels, see
/// contract/tissue.h), both with a linear transform whose scale is the voxel size in mm, and the metadata
/// "typodont_version". Further grids, if needed: "tissue_before_filling" (label before the filling, plus one),
/// "hardness" (int32, 1 to 255, background 255; dense_tissue.h) and "color" (int32, sRGB 0xRRGGBB, background −1: the
/// colour of the tissue; stored with 5, 6 and 5 bits). FilePlace of imported tissue: metadata
/// "typodont_file_rotation_x", _y, _z (rows of a rotation matrix), "typodont_file_origin" (mm) and "typodont_file_axes"
/// ("LPS" or "RAS") of the grid "distance".
class TissueVolume {
 public:
  explicit TissueVolume(const DenseTissue& dense);
  static TissueVolume load(const std::filesystem::path& file);
  ~TissueVolume();
  TissueVolume(TissueVolume&&) noexcept;
  TissueVolume& operator=(TissueVolume&&) noexcept;

  /// Writes the volume to a file, completely or not at all. Throws Error if the folder is not writable.
  void save(const std::filesystem::path& file) const;

  const VoxelFrame& frame() const;
  double band() const;  // m, limit of the stored distances
  /// Returns true if the stored distances outside the tissue were exact before the first cut.
  bool exact_outside() const;
  /// Returns where the tissue lies in the file from which it was imported; the identity for other tissue.
  const FilePlace& place() const;
  void set_place(const FilePlace& place);
  /// Sets `a_lo` and `a_hi` to the corners of the bounding box of all cuts inside the box lo..hi. Without cuts there,
  /// a_lo is larger than a_hi.
  void cut_box(const glm::ivec3& lo, const glm::ivec3& hi, glm::ivec3& a_lo, glm::ivec3& a_hi) const;
  /// Sets `lo` and `hi` to the bounding box (inclusive, voxels) of all voxels whose distance from the surface is less
  /// than band(). If there are none, lo is larger than hi.
  void bounds(glm::ivec3& lo, glm::ivec3& hi) const;

  /// Returns true if any voxel ever had another hardness than its tissue's own. Otherwise hardness uses no memory.
  bool graded() const;

  /// Returns true if any voxel ever had another colour than its tissue's.
  bool colored() const;
  /// Copies the colours of a box of voxels; z runs fastest.
  void copy_colors(const glm::ivec3& lo, const glm::ivec3& size, VoxelColor* color) const;
  /// Colour that a voxel shows instead of its tissue's, sRGB; w: 0 to 1, weight of this colour. `hardness`: fraction of
  /// the tissue's own.
  using PaintOf = std::function<glm::dvec4(Tissue tissue, double hardness, VoxelColor color)>;
  /// Interpolates `paint_of` of the eight voxels around a point (voxels). Returns the mean sRGB, weighted by w, and as
  /// w the mean w of those voxels that are not air.
  glm::vec4 paint_at(const dvec3& p_V, const PaintOf& paint_of) const;
  /// paint_at() with the voxels' colours. `tissues`: bit t is set if the colours of tissue t count.
  glm::vec4 color_at(const dvec3& p_V, std::uint32_t tissues = ~0u) const;

  /// Copies a box of samples from voxel `lo` on: distances in voxels (limited to the band), labels, and hardness
  /// (dense_tissue.h). z runs fastest. An array whose pointer is null is not copied.
  void copy(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue,
            std::uint8_t* hardness = nullptr) const;
  /// Copies a box of samples for a patch (the servo's copy of the tissue), with labels in the patch's encoding
  /// (label.h). A filled voxel has the hardness from before the filling.
  void copy_for_patch(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* labels,
                      std::uint8_t* hardness = nullptr) const;
  /// Sets `a_lo` and `a_hi` to the corners of the bounding box of all fillings inside the box lo..hi. Without fillings
  /// there, a_lo is larger than a_hi.
  void filled_box(const glm::ivec3& lo, const glm::ivec3& hi, glm::ivec3& a_lo, glm::ivec3& a_hi) const;

  /// Copies every n-th sample, for a coarse tissue patch; the first sample is at voxel n·lo. Distances are in coarse
  /// voxels; inside tissue, they may be −Sweep::kMargin, because the field is inexact there after a cut.
  void copy_every(int n, const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue,
                  std::uint8_t* hardness = nullptr) const;

  // The following functions update a box of copied samples, so that it need not be copied completely.
  /// Returns a number for the current state of the tissue, for written_since(). It is never 0, and differs between
  /// volumes.
  std::uint64_t mark();
  /// The samples that carve() and fill() have changed since a call of mark().
  struct Written {
    VoxelBox box;                    // bounding box, voxels
    std::vector<glm::ivec3> leaves;  // first voxel of each written leaf (8³ samples); a leaf may be listed twice
    bool listed = true;              // true: `leaves` contains all leaves; false: only `box` is known
  };
  /// Sets `written` to all writes of carve() and fill() since `mark`. Returns false if they are unknown: the mark is
  /// too old, or an undo or painting came after it.
  bool written_since(std::uint64_t mark, Written& written) const;
  /// Returns the number of changes that the servo does not make in its tissue patch itself: undo, redo, removal of a
  /// loose piece, painting, a placed implant.
  std::uint64_t foreign_changes() const;
  /// A box of copied samples: all voxels, or every n-th.
  struct Copied {
    glm::ivec3 lo, size;
    float* distance;
    Tissue* tissue;
    std::uint8_t* hardness = nullptr;
  };
  /// Copies samples as copy_for_patch() does, but only those of `part`, which is inside the box.
  void copy_part(const Copied& box, const VoxelBox& part) const;
  /// Copies samples as copy_part() does, but only those of whole leaves (8³ samples), which are inside the box.
  /// `leaves`: their first voxels.
  void copy_leaves(const Copied& box, std::span<const glm::ivec3> leaves) const;
  /// Appends the leaves of `part` to `step`, with their samples as copy_for_patch() copies them. `part` consists of
  /// whole leaves (8³ samples), and `step` must have memory for them.
  void copy_step(const VoxelBox& part, PatchStep& step) const;
  /// Copies every n-th sample as copy_every() does, but only the samples of `part`, which is inside the box.
  void copy_part_of_every(int n, const Copied& box, const VoxelBox& part) const;
  /// Returns the box of the samples of a coarse copy (every n-th sample) that may have changed if voxels inside the box
  /// `written` were changed.
  static VoxelBox every_around(int n, const VoxelBox& written);

  /// Result of a removal: bounding box of the writes, and blocks (see solid_block()) in which tissue may have become
  /// air.
  struct Carved {
    VoxelBox box;
    std::vector<BlockPart> blocks;
  };
  /// Removes the tissue inside the swept head: each distance becomes the larger of itself and the depth below the
  /// head's surface. Labels do not change, except where a filling was removed.
  Carved carve(const Sweep& sweep);
  /// Removes whole voxels: those whose centres lie in the head, whose shape and pose `stamp` contains.
  Carved carve(const VoxelStamp& stamp);

  /// Replaces the distances of a block; labels do not change. Returns the bounding box of the writes.
  VoxelBox replace(const RasterBlock& block);

  /// Adds a filling: each distance becomes the smaller of itself and its distance to the filling. Voxels that were
  /// empty get the label of the filling. Returns the bounding box of the writes.
  VoxelBox fill(const Fill& filling);
  /// Adds a body with the shape of a tool's head. Returns the bounding box of the writes.
  VoxelBox fill(const PlacedHead& body);

  /// Determines which samples of a block of 8³ samples are inside tissue. The first sample of the block is at voxel
  /// 8·key.
  void solid_block(const glm::ivec3& key, SolidBits& bits) const;
  /// Returns the tissues in a block of 8³ voxels: bit t is set if a voxel has the label t. The first voxel of the block
  /// is at 8·key.
  std::uint32_t tissues_in_block(const glm::ivec3& key) const;
  /// Returns the bounding box (voxels) of all blocks of 8³ voxels in which a voxel has this label.
  VoxelBox box_of(Tissue tissue) const;
  /// Returns true if any voxel has this label.
  bool contains(Tissue tissue) const { return !box_of(tissue).empty(); }

  /// Removes a loose piece and corrects the distances around it. Labels do not change. Returns the volume of the piece
  /// per tissue, m³.
  PerTissue remove_piece(const TissuePiece& piece);

  /// Gives all voxels with a label other than air whose centres are inside the solid a new label, hardness and colour.
  /// A filled voxel gets only the label. Returns false if the solid contains no tissue.
  bool paint(Tissue tissue, const Solid& solid, std::uint8_t hardness = kOwnHardness, VoxelColor color = kTissueColor);
  /// Returns how many calls of paint() have changed tissue.
  std::uint64_t paints() const;

  // Strokes: all cuts and paints from begin_stroke() on are undone and redone together. The memory is proportional to
  // the number of changed leaves (8³ voxels); nothing is stored before the first stroke.
  void begin_stroke();
  /// Ends the current stroke. A stroke without changes is discarded.
  void end_stroke();
  /// Returns the volume that undos have restored minus the volume that redos have removed again, m³; negative for
  /// undone fillings.
  const PerTissue& taken_back() const;
  /// undo() reverts the last stroke, and redo() repeats the stroke that was undone last. Each returns false if there is
  /// no such stroke. If a new stroke begins after an undo, the undone strokes are discarded.
  bool undo();
  bool redo();
  struct Strokes {
    std::size_t done = 0, undone = 0;  // number of strokes that can be undone, and that can be redone
    std::size_t bytes = 0;             // memory used by all strokes, bytes
  };
  Strokes strokes() const;

  /// Returns a copy of the tissue, without the strokes for undo.
  TissueVolume clone() const;

  /// Returns the mesh from which the volume was made, or null. Painting changes the labels of its triangles; cuts and
  /// fillings do not change it.
  const std::shared_ptr<const TissueMesh>& mesh() const;
  void set_mesh(std::shared_ptr<const TissueMesh> mesh);

  /// Returns the tissue before the first cut; null if neither keep_natural_surface() nor set_natural_surface() was
  /// called. Cuts, fillings and undo do not change this object; a clone() shares it.
  const std::shared_ptr<const NaturalSurface>& natural_surface() const;
  /// Stores the current tissue as the tissue before the first cut (NaturalSurface).
  void keep_natural_surface();
  /// For a volume that was computed from another volume: sets the tissue before the first cut (NaturalSurface).
  void set_natural_surface(std::shared_ptr<const NaturalSurface> natural);
  /// Returns the zero set of the field as triangles; see surface_mesh() in tissue_mesh.h.
  TissueMesh extract_mesh() const;

  /// Returns the keys of the bricks (blocks that are drawn as one, FieldBrick) through which the surface passes.
  std::vector<glm::ivec3> surface_bricks() const;
  /// Returns the keys of the bricks that have changed since the last call. A changed sample at the border of a brick
  /// also belongs to the neighbouring bricks.
  std::vector<glm::ivec3> take_changed_bricks();
  // Reads a brick (a block that is drawn as one). Without surface in the brick, its labels are kAir.
  void read_brick(const glm::ivec3& key, FieldBrick& brick) const;

  /// Returns the volume of each tissue, m³. A voxel at the surface counts with the fraction that lies inside.
  PerTissue volumes() const;
  /// Returns for each tissue the sum of (volume of a voxel × its hardness 0..1), m³. The ratio to volumes() is the mean
  /// hardness.
  PerTissue hardness_volumes() const;
  /// Returns the FNV-1a hash over all active samples in index order, including hardness and colours. Equal fields have
  /// equal hashes.
  std::uint64_t hash() const;

 private:
  struct Impl;
  template <class Removal>
  Carved carve_leaves(const Removal& removal);
  template <class Filling>
  VoxelBox fill_leaves(const Filling& filling);
  explicit TissueVolume(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// The tissue before the first cut. The renderer needs it because cut enamel and dentin look different from natural
/// surfaces. Immutable and shared by copies of a volume. Any thread.
class NaturalSurface {
 public:
  /// Stores the current tissue of `volume`; takes about 1 ms for a tooth.
  explicit NaturalSurface(const TissueVolume& volume);
  /// Returns whether a point was inside tissue before the first cut: 1 inside, 0 outside, about ½ at the surface;
  /// trilinear interpolation.
  double inside(const glm::dvec3& p_W) const;

 private:
  bool solid(const glm::ivec3& voxel) const;

  VoxelFrame frame_;
  // Box of all blocks of 8³ samples that contain tissue: first_ is the first block, count_ the number along each axis.
  glm::ivec3 first_{0}, count_{0};
  std::vector<std::int32_t> block_;  // for each block: kEmpty, kFull, or its index in mixed_
  std::vector<SolidBits> mixed_;
};

}  // namespace typodont::haptics
