#include "haptics/contact/offset/field_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/sweep.h"

namespace typodont::haptics::offset {

FieldBody::FieldBody(TissueVolume tissue, std::span<const Tool> tools, bool intermediate)
    : volume_(std::move(tissue)),
      tools_(tools.begin(), tools.end()),
      loose_pieces_(volume_),
      intermediate_(intermediate) {
  const double voxel = volume_.frame().voxel;
  travel_ = patch_travel_for(tools_, voxel) * voxel;
  coarse_ = coarse_grid_for(tools_, voxel, travel_ / voxel);
  choose_grid();
}

namespace {

/// Returns true if no tissue is near the six sides of the cube of `edge`³ voxels that starts at `lo`.
bool has_air_around(const TissueVolume& volume, const glm::ivec3& lo, int edge) {
  constexpr int kThick = 4;      // voxels, thickness of the examined layers, which lie inside the cube's six sides
  constexpr float kAway = 2.5f;  // voxels, smallest allowed distance between an examined layer and tissue
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {0, edge - kThick}) {
      glm::ivec3 from = lo, size(edge);
      from[axis] += side, size[axis] = kThick;
      std::vector<float> distance(static_cast<std::size_t>(edge) * edge * kThick);
      volume.copy(from, size, distance.data(), nullptr);
      if (std::ranges::min(distance) < kAway) return false;
    }
  }
  return true;
}

}  // namespace

/// Chooses the size of the tissue patch. If the patch of a large head would be larger than the tissue, a fixed patch
/// contains all tissue instead. Throws Error if the patch needs too much memory.
void FieldBody::choose_grid() {
  constexpr int kAir = 8;                            // voxels of air around the tissue
  constexpr double kLarge = 4e6;                     // samples; a tissue patch up to this size always follows the tool
  constexpr double kMaxSamples = 2e8, kPatches = 4;  // samples of a tissue patch, and patches of a session
  constexpr double kSampleBytes = sizeof(float) + sizeof(Tissue);
  const double voxel = volume_.frame().voxel;
  edge_ = patch_edge_for(tools_, voxel);
  glm::ivec3 lo, hi;
  volume_.bounds(lo, hi);
  const bool adds = std::ranges::any_of(tools_, [](const Tool& t) { return t.fill != Tissue::kAir || t.implant; });
  const glm::ivec3 first = (lo - kAir) & -Sweep::kLeaf, size = hi + kAir + 1 - first;
  const int edge = (std::max({size.x, size.y, size.z}) + Sweep::kLeaf - 1) & -Sweep::kLeaf;
  const auto samples = [](double n) { return n * n * n; };
  if (!adds && lo.x <= hi.x && samples(edge_) > kLarge && edge < edge_ && has_air_around(volume_, first, edge)) {
    edge_ = edge;
    whole_ = first;
    travel_ = std::numeric_limits<double>::infinity();
  }
  if (samples(edge_) <= kMaxSamples) return;
  const Tool& largest = *std::ranges::max_element(tools_, {}, near_reach);
  double least = voxel;
  while (samples(patch_edge_for(tools_, least)) > kMaxSamples) least *= 1.01;
  throw Error("tissue", "voxel_mm",
              fmt::format("{:g} mm with a head of {:g} x {:g} mm, which needs {:.1f} GB", voxel / kMillimetre,
                          largest.diameter / kMillimetre, 2 * largest.half() / kMillimetre,
                          kPatches * kSampleBytes * samples(edge_) / 1e9),
              fmt::format("at least {:.3g} mm, or a smaller head", std::ceil(least / 1e-6) * 1e-3));
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

namespace {

// Largest number of leaves (8³ samples) in a PatchStep. The servo copies them in one tick, 50 to 100 ns each, so
// copying takes no longer than a cut with a bur of 1.2 mm. If more leaves are new, the whole tissue patch is exchanged.
constexpr std::size_t kMaxInStep = 128;

}  // namespace

/// Returns an empty tissue patch with all memory allocated.
TissuePatch FieldBody::sized_patch() const {
  TissuePatch patch = empty_patch_for(tools_, volume_.frame().voxel, edge_);
  if (intermediate_) patch.intermediate.emplace_back().resize(edge_);
  return patch;
}

std::unique_ptr<Snapshot> FieldBody::make_snapshot() const {
  auto patch = std::make_unique<TissuePatch>(sized_patch());
  const auto edge = static_cast<std::size_t>(patch->n / PatchStep::kSide);
  if (edge * edge <= kMaxInStep) patch->step.reserve(std::min(PatchStep::most_for(static_cast<int>(edge)), kMaxInStep));
  return patch;
}

namespace {

TissueVolume::Copied whole(TissuePatch& patch) {
  return {patch.lo, glm::ivec3(patch.n), patch.distance.data(), patch.tissue.data(),
          patch.hardness.empty() ? nullptr : patch.hardness.data()};
}

VoxelBox box_of(const TissuePatch& patch) {
  return {patch.lo, patch.lo + patch.n - 1};
}

/// Calls visit(slab) for the parts of `box` outside the box `known`; for the whole `box` if the two do not overlap.
template <class Visit>
void for_new_slabs(VoxelBox box, const VoxelBox& known, Visit visit) {
  const VoxelBox stays = common(box, known);
  if (stays.empty()) return visit(box);
  // Along each axis, visits the parts of `box` on both sides of the common part `stays`, and removes them from `box`.
  for (int axis = 0; axis < 3; ++axis) {
    VoxelBox slab = box;
    slab.hi[axis] = stays.lo[axis] - 1;
    if (slab.lo[axis] <= slab.hi[axis]) visit(slab);
    slab = box;
    slab.lo[axis] = stays.hi[axis] + 1;
    if (slab.lo[axis] <= slab.hi[axis]) visit(slab);
    box.lo[axis] = stays.lo[axis], box.hi[axis] = stays.hi[axis];
  }
}

}  // namespace

/// First voxel of a tissue patch of `n`³ samples around `center_W`.
glm::ivec3 FieldBody::first_voxel(const dvec3& center_W, int n) const {
  if (whole_) return *whole_;
  const dvec3 center_V = volume_.frame().to_voxels(center_W);
  return glm::ivec3(glm::round((center_V - (n - 1) / 2.0) / static_cast<double>(Sweep::kLeaf))) * Sweep::kLeaf;
}

/// Moves a tissue patch to `lo` and copies samples of the volume to it: all samples, or, if the volume's changes since
/// the last copy are known, only the changed ones, those that the servo has written, and those new in the patch.
/// copy_part(box) copies all samples in a box, copy_written(written, inside) the changed samples in the box `inside`.
template <class CopyPart, class CopyWritten>
void FieldBody::renew(TissuePatch& patch, const glm::ivec3& lo, CopyPart copy_part, CopyWritten copy_written) {
  TissueVolume::Written written;
  const VoxelBox before = volume_.written_since(patch.copied_at, written) ? box_of(patch) : VoxelBox{};
  patch.move_to(lo);
  for_new_slabs(box_of(patch), before, copy_part);
  const VoxelBox stays = common(box_of(patch), before), own = common(stays, {patch.written_lo, patch.written_hi});
  if (!stays.empty() && !written.box.empty()) copy_written(written, stays);
  if (!own.empty()) copy_part(own);
  patch.written_lo = glm::ivec3(INT_MAX), patch.written_hi = glm::ivec3(INT_MIN);
  patch.copied_at = volume_.mark();
}

void FieldBody::cut_out(Snapshot& snapshot, std::uint32_t held) {
  auto& patch = static_cast<TissuePatch&>(snapshot);
  if (patch.n == 0) {  // the servo's first tissue patch, which has no memory yet
    TissuePatch sized = sized_patch();
    static_cast<Snapshot&>(sized) = patch;
    std::swap(sized.step, patch.step);
    patch = std::move(sized);
  }
  patch.whole = whole_.has_value();
  const glm::ivec3 lo = first_voxel(patch.center_W, patch.n), center = lo + patch.n / 2;
  patch.center_W = volume_.frame().to_world(dvec3(lo) + (patch.n - 1) / 2.0);
  patch.band = volume_.band() / volume_.frame().voxel;
  patch.exact_outside = volume_.exact_outside();
  if (volume_.graded()) patch.grade(), patch.step.grade();
  patch.from = held != 0 && copy_step(patch, lo, held) ? held : 0;
  if (patch.from == 0) cut_out_complete(patch, lo);
  last_ = {patch.number, lo, volume_.foreign_changes()};
  for (TissuePatch& coarse : patch.coarse_levels) {
    const int n = coarse_.every;
    coarse.number = patch.number;
    coarse.whole = patch.whole;
    coarse.band = patch.band / n;
    coarse.exact_outside = patch.exact_outside;
    if (volume_.graded()) coarse.hardness.resize(coarse.tissue.size());
    // The coarse patch is never sent as a PatchStep: the servo's coarse patch differs, because its cuts are longer.
    const auto copy_part = [&](const VoxelBox& part) { volume_.copy_part_of_every(n, whole(coarse), part); };
    renew(coarse, center / n - coarse_.edge / 2, copy_part,
          [&](const TissueVolume::Written& written, const VoxelBox& inside) {
            const VoxelBox changed = common(TissueVolume::every_around(n, written.box), inside);
            if (!changed.empty()) copy_part(changed);
          });
  }
  mark_cut_boxes(patch);
  for (TissuePatch& copy : patch.intermediate) {
    if (patch.from != 0) break;
    copy.lo = patch.lo, copy.n = patch.n;
    copy.whole = patch.whole, copy.band = patch.band, copy.exact_outside = patch.exact_outside;
    copy.distance = patch.distance, copy.tissue = patch.tissue, copy.hardness = patch.hardness;
  }
}

/// Copies a complete tissue patch that starts at `lo`.
void FieldBody::cut_out_complete(TissuePatch& patch, const glm::ivec3& lo) {
  const auto copy_part = [&](VoxelBox part) {
    // Rounds the box to whole leaves (8³ samples), which are copied faster.
    for (int axis = 0; axis < 3; ++axis) part.lo[axis] &= -Sweep::kLeaf, part.hi[axis] |= Sweep::kLeaf - 1;
    volume_.copy_part(whole(patch), common(part, box_of(patch)));
  };
  renew(patch, lo, copy_part, [&](TissueVolume::Written& written, const VoxelBox& inside) {
    if (written.listed) {
      std::erase_if(written.leaves, [&](const glm::ivec3& leaf) { return common({leaf, leaf}, inside).empty(); });
      return volume_.copy_leaves(whole(patch), written.leaves);
    }
    // Labels of samples next to changed samples may also have changed.
    const VoxelBox changed = common({written.box.lo - 1, written.box.hi + 1}, inside);
    if (!changed.empty()) copy_part(changed);
  });
}

/// Copies only the leaves (8³ samples) that the servo's patch, number `held`, lacks. Returns false if `held` is not the
/// last copied patch, if the tissue has changes that the servo did not make, or if there are too many leaves.
bool FieldBody::copy_step(TissuePatch& patch, const glm::ivec3& lo, std::uint32_t held) {
  if (held != last_.number || last_.foreign_changes != volume_.foreign_changes()) return false;
  const VoxelBox before{last_.lo, last_.lo + patch.n - 1}, now{lo, lo + patch.n - 1};
  std::size_t leaves = 0;
  for_new_slabs(now, before,
                [&](const VoxelBox& slab) { leaves += voxel_count((slab.hi - slab.lo + 1) / PatchStep::kSide); });
  if (leaves > patch.step.most()) return false;
  // `patch` has only the new samples, not those that the servo keeps, so the next copy to it must be complete.
  patch.lo = lo;
  patch.copied_at = 0;
  patch.step.clear();
  for_new_slabs(now, before, [&](const VoxelBox& slab) { volume_.copy_step(slab, patch.step); });
  return true;
}

void FieldBody::bring_up_to_date(Snapshot& snapshot) {
  cut_out(snapshot, 0);
}

/// Sets the tissue patch's boxes around all cut samples and around all filled samples.
void FieldBody::mark_cut_boxes(TissuePatch& patch) const {
  volume_.cut_box(patch.lo, patch.lo + patch.n - 1, patch.cut_lo, patch.cut_hi);
  volume_.filled_box(patch.lo, patch.lo + patch.n - 1, patch.filled_lo, patch.filled_hi);
  for (TissuePatch& coarse : patch.coarse_levels) {
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
