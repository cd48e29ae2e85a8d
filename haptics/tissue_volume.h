// The tissue: a sparse signed distance field and a label per voxel, kept in OpenVDB behind this header.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/dense_tissue.h"
#include "haptics/fill.h"
#include "haptics/hardness.h"
#include "haptics/sweep.h"
#include "haptics/volume/loose_pieces.h"

namespace typodont::haptics {

class NaturalSurface;
class Solid;
class PlacedHead;
class VoxelStamp;
struct TissueMesh;

/// Samples lo .. lo+size-1 of a field, in voxels, z fastest.
struct RasterBlock {
  glm::ivec3 lo, size;
  std::vector<float> distance;
};

/// Sole owner of the tissue. One thread at a time (the carver's). Set-up functions throw Error.
///
/// File format (.vdb): grids "distance" (float, mm, level set, background = band) and "tissue" (int32 labels, see
/// contract/tissue.h), both with the voxel in mm as linear transform, and metadata "typodont_version". A file with
/// fillings has a third grid, "tissue_before_filling": the label before the filling, plus one. If any voxel's hardness
/// is not its tissue's own, the file has a grid "hardness": int32, 1 to 255, see hardness.h; background 255.
class TissueVolume {
 public:
  explicit TissueVolume(const DenseTissue& dense);
  static TissueVolume load(const std::filesystem::path& file);
  ~TissueVolume();
  TissueVolume(TissueVolume&&) noexcept;
  TissueVolume& operator=(TissueVolume&&) noexcept;

  /// Writes the whole file or nothing. Throws Error if the folder is not writable.
  void save(const std::filesystem::path& file) const;

  const VoxelFrame& frame() const;
  double band() const;  // m
  /// True if distances outside the tissue were true distances before the first cut.
  bool exact_outside() const;
  /// The bounding box of all cuts within lo .. hi; a_lo > a_hi if there are none.
  void cut_box(const glm::ivec3& lo, const glm::ivec3& hi, glm::ivec3& a_lo, glm::ivec3& a_hi) const;
  /// Inclusive bounds, in voxels, of all voxels nearer to a surface than the band; lo > hi if there are none.
  void bounds(glm::ivec3& lo, glm::ivec3& hi) const;

  /// True if any voxel was ever given a hardness other than its tissue's own. While false, hardness needs no memory.
  bool graded() const;

  /// Copies a box of samples starting at voxel `lo`: distances in voxels (clamped to the band), labels, hardness (see
  /// hardness.h). z fastest. An array whose pointer is null is not copied.
  void copy(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue,
            std::uint8_t* hardness = nullptr) const;
  /// Like copy(), but with labels in the encoding of a patch (see label.h). The hardness of a filled voxel is the one
  /// that it had before the filling.
  void copy_for_patch(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* labels,
                      std::uint8_t* hardness = nullptr) const;
  /// The bounding box of all fillings within lo .. hi; a_lo > a_hi if there are none.
  void filled_box(const glm::ivec3& lo, const glm::ivec3& hi, glm::ivec3& a_lo, glm::ivec3& a_hi) const;

  /// Copies every n-th sample of a box; the first is at n·lo. Distances are in voxels n times as large. Near a cut the
  /// field is exact only close to the surface; deeper samples get the distance −Sweep::kMargin. `hardness` may be null.
  void copy_every(int n, const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue,
                  std::uint8_t* hardness = nullptr) const;

  // The functions below update a copied box of samples instead of copying it again.
  /// Returns a number for the present state of the tissue, for written_since(). It is never 0 and never the number of
  /// another volume.
  std::uint64_t mark();
  /// The places where carve() and fill() have written since a mark.
  struct Written {
    std::vector<glm::ivec3> blocks;  // keys, see solid_block(); a key may occur more than once
    VoxelBox box;                    // bounding box of all writes
  };
  /// Returns false if the writes since `mark` are no longer known: after undo or painting, or if there were too many.
  bool written_since(std::uint64_t mark, Written& written) const;
  /// A copied box of samples: of every voxel, or of every n-th voxel.
  struct Copied {
    glm::ivec3 lo, size;
    float* distance;
    Tissue* tissue;
    std::uint8_t* hardness = nullptr;
  };
  /// Like copy_for_patch(), but copies only the samples of `part`, which lies in the box.
  void copy_part(const Copied& box, const VoxelBox& part) const;
  /// Like copy_part(), but for the parts of the blocks `keys` that lie in the box.
  void copy_blocks(const Copied& box, std::span<const glm::ivec3> keys) const;
  /// Like copy_every(), but copies only the samples of `part`, which lies in the box.
  void copy_part_of_every(int n, const Copied& box, const VoxelBox& part) const;
  /// The box of those n-th samples that may have changed after writes within `written`.
  static VoxelBox every_around(int n, const VoxelBox& written);

  /// The bounding box of a removal's writes, and the keys of the blocks (see solid_block()) in which tissue may have
  /// become air.
  struct Carved {
    VoxelBox box;
    std::vector<glm::ivec3> blocks;
  };
  /// Removes the tissue that the swept head covers: each distance becomes the maximum of itself and the depth below the
  /// head's surface. Labels stay, except those of a filling that was removed.
  Carved carve(const Sweep& sweep);
  /// Removes whole voxels.
  Carved carve(const VoxelStamp& stamp);

  /// Replaces the distances of a block. Labels stay. Returns the bounding box of the writes.
  VoxelBox replace(const RasterBlock& block);

  /// Adds a filling: each distance becomes the minimum of itself and the distance to the filling, and voxels that were
  /// empty get its label. Returns the bounding box of the writes.
  VoxelBox fill(const Fill& filling);
  /// Adds a body with the shape of a head. Returns the bounding box of the writes.
  VoxelBox fill(const PlacedHead& body);

  /// Finds which samples of a block of 8³ lie in tissue. The first sample of the block is at 8·key.
  void solid_block(const glm::ivec3& key, SolidBits& bits) const;

  /// Removes a piece that is connected to nothing, and corrects the distances around it. Labels stay. Returns its
  /// volume per tissue, m³.
  PerTissue remove_piece(const TissuePiece& piece);

  /// Gives all tissue inside the solid (voxel centres, including one voxel beyond the surface) another label and
  /// hardness. Filled voxels get only the label. Returns false if the solid contains no tissue.
  bool paint(Tissue tissue, const Solid& solid, std::uint8_t hardness = kOwnHardness);
  /// Number of calls of paint() that changed tissue.
  std::uint64_t paints() const;

  // Strokes: all cuts and paints from begin_stroke() on are undone and redone together. The memory is proportional to
  // the number of changed leaves (8³ voxels); nothing is stored before the first stroke.
  void begin_stroke();
  /// Ends the present stroke. A stroke that changed nothing is discarded.
  void end_stroke();
  /// Volume that all undos so far brought back, minus what redos removed again, m³ (negative for undone fillings).
  const PerTissue& taken_back() const;
  /// undo() and redo() return false if there is no stroke to undo or redo. A stroke that begins after an undo discards
  /// what was undone.
  bool undo();
  bool redo();
  struct Strokes {
    std::size_t done = 0, undone = 0;  // strokes that can be undone, and redone
    std::size_t bytes = 0;             // bytes, memory of all strokes
  };
  Strokes strokes() const;

  /// A copy of the tissue without its strokes.
  TissueVolume clone() const;

  /// The mesh from which the volume was made; null if it was not made from a mesh. Painting changes the labels of its
  /// triangles; cuts and fillings do not change it.
  const std::shared_ptr<const TissueMesh>& mesh() const;
  void set_mesh(std::shared_ptr<const TissueMesh> mesh);

  /// The tissue before the first cut; null if keep_natural_surface() was not called. Cuts, fillings and undo do not
  /// change it, and clone() shares it.
  const std::shared_ptr<const NaturalSurface>& natural_surface() const;
  /// Keeps the present tissue as the natural one.
  void keep_natural_surface();
  /// For a volume that was computed from another one.
  void set_natural_surface(std::shared_ptr<const NaturalSurface> natural);
  /// The zero set of the field as triangles, see surface_mesh() in tissue_mesh.h.
  TissueMesh extract_mesh() const;

  /// Keys of the bricks (see FieldBrick) that contain surface.
  std::vector<glm::ivec3> surface_bricks() const;
  /// Keys of the bricks that changed since the last call, including neighbours that share samples with them.
  std::vector<glm::ivec3> take_changed_bricks();
  void read_brick(const glm::ivec3& key, FieldBrick& brick) const;

  /// Volume per tissue, m³. Each voxel counts with the fraction of it that lies inside the surface.
  PerTissue volumes() const;
  /// Like volumes(), but each voxel's volume is multiplied by its hardness, 0..1. The ratio to volumes() is the mean
  /// hardness.
  PerTissue hardness_volumes() const;
  /// FNV-1a over the bytes of all active samples in index order, hardness included: equal fields, equal hashes.
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

}  // namespace typodont::haptics
