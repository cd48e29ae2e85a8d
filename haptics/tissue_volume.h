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
/// contract/tissue.h), both with the voxel in mm as linear transform, and metadata "typodont_version". Where something
/// was filled, a third, "tissue_before_filling": the label from before, plus one. Where the hardness of any voxel is
/// not its tissue's own, another, "hardness": int32, 1 to 255, see hardness.h; background 255.
class TissueVolume {
 public:
  explicit TissueVolume(const DenseTissue& dense);
  static TissueVolume load(const std::filesystem::path& file);
  ~TissueVolume();
  TissueVolume(TissueVolume&&) noexcept;
  TissueVolume& operator=(TissueVolume&&) noexcept;

  /// Writes whole or not at all. Throws Error when the place is not writable.
  void save(const std::filesystem::path& file) const;

  const VoxelFrame& frame() const;
  double band() const;  // m
  /// True when distances outside the tissue were true distances before anything was cut.
  bool exact_outside() const;
  /// A box around all that was cut within lo .. hi since; a_lo > a_hi when nothing was.
  void cut_box(const glm::ivec3& lo, const glm::ivec3& hi, glm::ivec3& a_lo, glm::ivec3& a_hi) const;
  /// Inclusive bounds, in voxels, of all voxels nearer than the band to a surface; lo > hi when there is none.
  void bounds(glm::ivec3& lo, glm::ivec3& hi) const;

  /// Whether any voxel was ever given a hardness other than its tissue's own. While false, hardness needs no memory.
  bool graded() const;

  /// Copies a box of samples starting at voxel `lo`: distances in voxels (clamped to the band), labels, hardness (see
  /// hardness.h). z fastest. Null pointers are left out.
  void copy(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue,
            std::uint8_t* hardness = nullptr) const;
  /// The same with labels as a patch keeps them (see label.h); hardness of a filled voxel is that of what was there
  /// before the filling.
  void copy_for_patch(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* labels,
                      std::uint8_t* hardness = nullptr) const;
  /// A box around all that was filled within lo .. hi; a_lo > a_hi when nothing was.
  void filled_box(const glm::ivec3& lo, const glm::ivec3& hi, glm::ivec3& a_lo, glm::ivec3& a_hi) const;

  /// Every n-th sample of a box, the first n·lo: distances in voxels n times as large, labels. Where something was cut
  /// the field knows only what is near; deeper it then says no more than that it is deep.
  /// Hardness where a pointer is given.
  void copy_every(int n, const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue,
                  std::uint8_t* hardness = nullptr) const;

  // Copies that are brought up to date instead of being made anew.
  /// Names the state of the tissue now, for written_since(). Never 0, and never that of another volume.
  std::uint64_t mark();
  /// What carve() and fill() have written since a mark.
  struct Written {
    std::vector<glm::ivec3> blocks;  // keys, see solid_block(); may repeat
    VoxelBox box;                    // around all of it
  };
  /// False where that is no longer known: after undo, or painting, or if it is too long ago.
  bool written_since(std::uint64_t mark, Written& written) const;
  /// A box of samples that was copied: of voxels, or of every n-th of them.
  struct Copied {
    glm::ivec3 lo, size;
    float* distance;
    Tissue* tissue;
    std::uint8_t* hardness = nullptr;
  };
  /// As copy_for_patch(), of the samples of `part` alone, which lies in the box.
  void copy_part(const Copied& box, const VoxelBox& part) const;
  /// The same of those blocks, as far as they lie in the box.
  void copy_blocks(const Copied& box, std::span<const glm::ivec3> keys) const;
  /// As copy_every(), of the samples of `part` alone, which lies in the box.
  void copy_part_of_every(int n, const Copied& box, const VoxelBox& part) const;
  /// The box of every n-th sample that may have changed where something was written within `written`.
  static VoxelBox every_around(int n, const VoxelBox& written);

  /// Where a removal wrote, and the keys of the blocks (see solid_block()) in which it may have turned tissue to air.
  struct Carved {
    VoxelBox box;
    std::vector<glm::ivec3> blocks;
  };
  /// Takes away what the swept head covers: raises the field to its depth, wherever that is higher. Labels stay,
  /// but those of a filling where none is left.
  Carved carve(const Sweep& sweep);
  /// Clears whole voxels.
  Carved carve(const VoxelStamp& stamp);

  /// Makes a block of samples what they are given to be. Labels stay. Returns where it wrote.
  VoxelBox replace(const RasterBlock& block);

  /// Adds a filling: lowers the field to it, wherever that is lower, and labels what was empty. Returns where it wrote.
  VoxelBox fill(const Fill& filling);
  /// Adds a body in the shape of a head. Returns where it wrote.
  VoxelBox fill(const PlacedHead& body);

  /// The samples of a block of 8³ that lie in tissue; its first sample is 8 key.
  void solid_block(const glm::ivec3& key, SolidBits& bits) const;

  /// Takes out a piece that hangs on to nothing, and with it what it meant for the distances around it. Labels stay.
  /// Returns its volume per tissue, m³.
  PerTissue take_out(const TissuePiece& piece);

  /// Gives all tissue inside the solid (voxel centres, one voxel beyond the surface included) another label and
  /// hardness. Filled voxels get the label alone. False where there was no tissue inside it.
  bool paint(Tissue tissue, const Solid& solid, std::uint8_t hardness = kOwnHardness);
  /// How often that was done.
  std::uint64_t paints() const;

  // Strokes: what is carved and painted from begin_stroke() on can be taken back as one, and brought again. Memory goes
  // with the leaves (8³ voxels) that were written to; nothing is kept before the first stroke.
  void begin_stroke();
  /// Nothing more comes to the stroke that was begun; one that changed nothing is forgotten.
  void end_stroke();
  /// What came back by all undoing so far, less what went again, m³ (negative where fillings were taken back).
  const PerTissue& taken_back() const;
  /// False when there is none. A stroke begun after an undo forgets what was undone.
  bool undo();
  bool redo();
  struct Strokes {
    std::size_t done = 0, undone = 0;  // that can be taken back, and brought again
    std::size_t bytes = 0;             // kept for them
  };
  Strokes strokes() const;

  /// The same tissue once more, without its strokes.
  TissueVolume clone() const;

  /// The mesh that the volume was made from; null where it was made otherwise. Painting relabels its triangles; cuts
  /// and fillings do not change it.
  const std::shared_ptr<const TissueMesh>& mesh() const;
  void set_mesh(std::shared_ptr<const TissueMesh> mesh);
  /// The zero set of the field as triangles, see surface_mesh() in tissue_mesh.h.
  TissueMesh extract_mesh() const;

  /// Bricks (see FieldBrick) that hold surface.
  std::vector<glm::ivec3> surface_bricks() const;
  /// Bricks changed since the last call, neighbours that share samples included.
  std::vector<glm::ivec3> take_changed_bricks();
  void read_brick(const glm::ivec3& key, FieldBrick& brick) const;

  /// Volume per tissue, m³: every voxel counts by its share inside the surface.
  PerTissue volumes() const;
  /// The same with every voxel's volume times its hardness, 0..1. The quotient with volumes() is the mean hardness.
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
