#include "haptics/contact/offset/field_body.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <utility>

#include "haptics/sweep.h"

namespace typodont::haptics::offset {

FieldBody::FieldBody(TissueVolume tissue, std::span<const Tool> tools)
    : volume_(std::move(tissue)), tools_(tools.begin(), tools.end()), loose_pieces_(volume_) {
  set_laws(laws_);
}

void FieldBody::set_laws(std::uint32_t laws) {
  laws_ = laws;
  loose_pieces_.set_laws(laws);
  const double voxel = volume_.frame().voxel, travel = patch_travel_for(tools_, voxel, laws);
  travel_ = travel * voxel;
  coarse_ = coarse_grid_for(tools_, voxel, travel_ / voxel);
}

void FieldBody::carve(const Cut& cut, bool continues) {
  take_out_pieces(cut, volume_.carve(Sweep(tool(cut), cut.X_WA, cut.X_WB, volume_.frame(), continues, laws_)));
}

void FieldBody::fill(const Cut& cut) {
  after_fill(volume_.fill(Fill(tool(cut), cut.X_WA.p, cut.fill_radius, cut.X_WB, volume_.frame())));
}

void FieldBody::take_out_pieces(const Cut& cut, const TissueVolume::Carved& carved) {
  if (carved.box.empty()) return;
  const std::vector<TissuePiece> pieces = loose_pieces_.after_cut(volume_, carved.box, carved.blocks);
  for (const TissuePiece& piece : pieces) {
    LoosePiece loose{cut.index, cut.t, {}, 0, volume_.remove_piece(piece)};
    dvec3 lo(1e300), hi(-1e300);
    for (const BlockPart& part : piece) {
      lo = glm::min(lo, dvec3(part.key * 8)), hi = glm::max(hi, dvec3(part.key * 8 + 7));
    }
    const dvec3 edges = hi - lo;
    loose.center_W = volume_.frame().to_world((lo + hi) / 2.0);
    loose.radius = std::max({edges.x, edges.y, edges.z}) / 2 * volume_.frame().voxel;
    pieces_.push_back(loose);
  }
  loose_pieces_.removed(pieces);
}

bool FieldBody::undo() {
  if (!volume_.undo()) return false;
  loose_pieces_.after_edit();
  return true;
}

bool FieldBody::redo() {
  if (!volume_.redo()) return false;
  loose_pieces_.after_edit();
  return true;
}

std::unique_ptr<Snapshot> FieldBody::make_snapshot() const {
  return std::make_unique<SurfacePatch>(empty_patch_for(tools_, volume_.frame().voxel, laws_));
}

namespace {

TissueVolume::Copied whole(SurfacePatch& patch) {
  return {patch.lo, glm::ivec3(patch.n), patch.distance.data(), patch.tissue.data(),
          patch.hardness.empty() ? nullptr : patch.hardness.data()};
}

}  // namespace

/// Moves a patch (dense copy of the field around the tool) so that its first voxel is `lo`, and updates its samples
/// from the volume. `known`: false: all samples are copied; true: written_ contains all changes of the volume since the
/// last copy. In this case only three parts are copied: these changes, the samples that the servo wrote itself, and the
/// new samples on the sides to which the patch has moved. copy_part(box) copies a box; copy_written() copies the
/// changes in written_.
template <class CopyPart, class CopyWritten>
void FieldBody::renew(SurfacePatch& patch, const glm::ivec3& lo, bool known, CopyPart copy_part,
                      CopyWritten copy_written) {
  VoxelBox left{lo, lo + patch.n - 1};  // box of the samples that are not copied yet
  const VoxelBox stays = common(left, {patch.lo, patch.lo + patch.n - 1});
  patch.move_to(lo);
  if (!known || stays.empty()) {
    copy_part(left);
  } else {
    // Copies the slab of new samples on each side of the patch along this axis. `left`: the box of the samples that are
    // not copied yet; each copied slab makes it smaller.
    for (int axis = 0; axis < 3; ++axis) {
      VoxelBox slab = left;
      slab.hi[axis] = stays.lo[axis] - 1;
      if (slab.lo[axis] <= slab.hi[axis]) copy_part(slab);
      slab = left;
      slab.lo[axis] = stays.hi[axis] + 1;
      if (slab.lo[axis] <= slab.hi[axis]) copy_part(slab);
      left.lo[axis] = stays.lo[axis], left.hi[axis] = stays.hi[axis];
    }
    copy_written();
    VoxelBox own = common(stays, {patch.written_lo, patch.written_hi});
    if (!own.empty()) {
      // If the patch consists of whole leaves, the box is extended to whole leaves, because they are copied faster.
      const glm::ivec3 bits = patch.lo | glm::ivec3(patch.n);
      for (int axis = 0; axis < 3 && ((bits.x | bits.y | bits.z) & (Sweep::kLeaf - 1)) == 0; ++axis)
        own.lo[axis] &= -Sweep::kLeaf, own.hi[axis] |= Sweep::kLeaf - 1;
      copy_part(own);
    }
  }
  patch.written_lo = glm::ivec3(INT_MAX), patch.written_hi = glm::ivec3(INT_MIN);
}

/// Returns the first voxel of a patch with `n` samples along each axis that is centred near `center_W`.
glm::ivec3 FieldBody::first_voxel(const dvec3& center_W, int n) const {
  const dvec3 center_V = volume_.frame().to_voxels(center_W);
  if (laws_ < kLawsOfAlignedPatches) return glm::ivec3(glm::round(center_V)) - n / 2;
  return glm::ivec3(glm::round((center_V - (n - 1) / 2.0) / static_cast<double>(Sweep::kLeaf))) * Sweep::kLeaf;
}

void FieldBody::cut_out(Snapshot& snapshot) {
  auto& patch = static_cast<SurfacePatch&>(snapshot);
  const glm::ivec3 lo = first_voxel(patch.center_W, patch.n), center = lo + patch.n / 2;
  if (laws_ >= kLawsOfAlignedPatches) patch.center_W = volume_.frame().to_world(dvec3(lo) + (patch.n - 1) / 2.0);
  patch.band = volume_.band() / volume_.frame().voxel;
  patch.exact_outside = volume_.exact_outside();
  if (volume_.graded()) patch.grade();
  const bool known = volume_.written_since(patch.copied_at, written_);
  renew(
      patch, lo, known, [&](const VoxelBox& part) { volume_.copy_part(whole(patch), part); },
      [&] { volume_.copy_blocks(whole(patch), written_.blocks); });
  for (SurfacePatch& coarse : patch.coarse_levels) {
    const int n = coarse_.every;
    coarse.number = patch.number;
    coarse.band = patch.band / n;
    coarse.exact_outside = patch.exact_outside;
    if (volume_.graded()) coarse.hardness.resize(coarse.tissue.size());
    const auto copy_part = [&](const VoxelBox& part) { volume_.copy_part_of_every(n, whole(coarse), part); };
    renew(coarse, center / n - coarse_.edge / 2, known, copy_part, [&] {
      if (written_.box.empty()) return;
      const VoxelBox part = common(TissueVolume::every_around(n, written_.box), {coarse.lo, coarse.lo + coarse.n - 1});
      if (!part.empty()) copy_part(part);
    });
  }
  patch.copied_at = volume_.mark();
  mark_cut_boxes(patch);
}

void FieldBody::bring_up_to_date(Snapshot& snapshot) {
  cut_out(snapshot);
}

/// Stores in the patch (the servo's copy of the field around the tool) the boxes in which samples were cut or filled.
void FieldBody::mark_cut_boxes(SurfacePatch& patch) const {
  volume_.cut_box(patch.lo, patch.lo + patch.n - 1, patch.cut_lo, patch.cut_hi);
  volume_.filled_box(patch.lo, patch.lo + patch.n - 1, patch.filled_lo, patch.filled_hi);
  for (SurfacePatch& coarse : patch.coarse_levels) {
    volume_.cut_box(coarse.lo * coarse_.every, (coarse.lo + coarse_.edge - 1) * coarse_.every, coarse.cut_lo,
                    coarse.cut_hi);
    if (coarse.cut_lo.x > coarse.cut_hi.x) continue;
    coarse.cut_lo = coarse.cut_lo / coarse_.every - 1, coarse.cut_hi = coarse.cut_hi / coarse_.every + 1;
  }
}

std::uint64_t FieldBody::elements() const {
  const PerTissue volumes = volume_.volumes();
  const double h = volume_.frame().voxel;
  return static_cast<std::uint64_t>(std::llround(total(volumes) / (h * h * h)));
}

}  // namespace typodont::haptics::offset
