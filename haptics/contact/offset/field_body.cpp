#include "haptics/contact/offset/field_body.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptics/sweep.h"

namespace typodont::haptics::offset {

FieldBody::FieldBody(TissueVolume tissue, std::span<const Tool> tools)
    : volume_(std::move(tissue)), tools_(tools.begin(), tools.end()), loose_pieces_(volume_) {
  const double voxel = volume_.frame().voxel, travel = patch_travel_for(tools_, voxel);
  travel_ = travel * voxel;
  coarse_ = wide_grid_for(tools_, voxel, travel_ / voxel);
}

void FieldBody::carve(const Cut& cut, bool continues) {
  take_out_pieces(cut, volume_.carve(Sweep(tool(cut), cut.X_WA, cut.X_WB, volume_.frame(), continues)));
}

void FieldBody::fill(const Cut& cut) {
  after_fill(volume_.fill(Fill(tool(cut), cut.X_WA.p, cut.fill_radius, cut.X_WB, volume_.frame())));
}

void FieldBody::take_out_pieces(const Cut& cut, const TissueVolume::Carved& carved) {
  if (carved.box.empty()) return;
  const std::vector<TissuePiece> pieces = loose_pieces_.after_cut(volume_, carved.box, carved.blocks);
  for (const TissuePiece& piece : pieces) {
    LoosePiece loose{cut.index, cut.t, {}, 0, volume_.take_out(piece)};
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
  return std::make_unique<SurfacePatch>(empty_patch_for(tools_, volume_.frame().voxel));
}

void FieldBody::cut_out(Snapshot& snapshot) {
  auto& patch = static_cast<SurfacePatch&>(snapshot);
  const glm::ivec3 center(glm::round(volume_.frame().to_voxels(patch.center_W)));
  patch.lo = center - patch.n / 2;
  patch.band = volume_.band() / volume_.frame().voxel;
  patch.exact_outside = volume_.exact_outside();
  const bool graded = volume_.graded();
  if (graded) patch.grade();
  volume_.copy_for_patch(patch.lo, glm::ivec3(patch.n), patch.distance.data(), patch.tissue.data(),
                         graded ? patch.hardness.data() : nullptr);
  for (SurfacePatch& coarse : patch.wide) {
    coarse.number = patch.number;
    coarse.lo = center / coarse_.every - coarse_.edge / 2;
    coarse.band = patch.band / coarse_.every;
    coarse.exact_outside = patch.exact_outside;
    if (graded) coarse.hardness.resize(coarse.tissue.size());
    volume_.copy_every(coarse_.every, coarse.lo, glm::ivec3(coarse_.edge), coarse.distance.data(), coarse.tissue.data(),
                       graded ? coarse.hardness.data() : nullptr);
  }
  mark_cut_boxes(patch);
}

void FieldBody::bring_up_to_date(Snapshot& snapshot) {
  auto& patch = static_cast<SurfacePatch&>(snapshot);
  const auto whole = [](SurfacePatch& p) {
    return TissueVolume::Copied{p.lo, glm::ivec3(p.n), p.distance.data(), p.tissue.data(),
                                p.hardness.empty() ? nullptr : p.hardness.data()};
  };
  const TissueVolume::Copied coarse = patch.wide.empty() ? TissueVolume::Copied{} : whole(patch.wide.front());
  volume_.copy_written(whole(patch), coarse_.every, patch.wide.empty() ? nullptr : &coarse);
  mark_cut_boxes(patch);
}

/// Tells the patch in which boxes anything was cut or filled.
void FieldBody::mark_cut_boxes(SurfacePatch& patch) const {
  volume_.cut_box(patch.lo, patch.lo + patch.n - 1, patch.cut_lo, patch.cut_hi);
  volume_.filled_box(patch.lo, patch.lo + patch.n - 1, patch.filled_lo, patch.filled_hi);
  for (SurfacePatch& coarse : patch.wide) {
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
