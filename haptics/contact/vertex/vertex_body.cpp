#include "haptics/contact/vertex/vertex_body.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "engine/base/voxels.h"
#include "haptics/contact/vertex/mesh_field.h"
#include "haptics/volume/label.h"

namespace typodont::haptics::vertex {

namespace {

double finest_edge(std::span<const Tool> tools, const Parameters& parameters) {
  double finest = std::numeric_limits<double>::infinity();
  for (const Tool& tool : tools) finest = std::min(finest, parameters.edge_for(tool));
  return CutParameters::longest * finest;
}

/// Tissue of every voxel; null: there is only one tissue.
SharedLabels labels_of(const TissueVolume& volume) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  if (glm::any(glm::greaterThan(lo, hi))) return nullptr;
  auto labels = std::make_shared<DenseTissue>();
  labels->frame = volume.frame();
  labels->frame.origin = volume.frame().to_world(dvec3(lo));
  labels->size = hi - lo + 1;
  labels->tissue.resize(static_cast<std::size_t>(labels->size.x) * static_cast<std::size_t>(labels->size.y) *
                        static_cast<std::size_t>(labels->size.z));
  volume.copy(lo, labels->size, nullptr, labels->tissue.data());
  Tissue only = Tissue::kAir;
  for (const Tissue label : labels->tissue) {
    const Tissue t = shown(label);
    if (t == Tissue::kAir || t == only) continue;
    if (only != Tissue::kAir) return labels;
    only = t;
  }
  return nullptr;
}

}  // namespace

VertexBody::VertexBody(TissueVolume tissue, const TissueMesh& mesh, std::span<const Tool> tools,
                       const Parameters& parameters)
    : volume_(std::move(tissue)),
      strokes_before_(volume_.strokes().done),
      untouched_(volume_.clone()),
      parameters_(parameters),
      mesh_(mesh, finest_edge(tools, parameters), parameters.spare),
      labels_(labels_of(untouched_)),
      cutter_(mesh_, labels_) {
  for (const Tool& tool : tools) {
    heads_.emplace_back(tool);
    edges_.push_back(parameters.edge_for(tool));
  }
}

CutDone VertexBody::make(mesh::EditableMesh& mesh, MeshCutter& cutter, const Cut& cut) const {
  return make_cut(mesh, cutter, heads_[cut.tool], edges_[cut.tool], parameters_.as_printed, cut.X_WA, cut.X_WB);
}

void VertexBody::carve(const Cut& cut, bool) {
  const CutDone done = make(mesh_, cutter_, cut);
  if (remembers_) written_.push_back(cut);
  if (!done.changed) return;
  for (std::size_t t = 0; t < done.removed.size(); ++t) removed_[t] += done.removed[t];
  // Box of blocks whose field the cut may have changed: head at both poses, enlarged by an edge length and four voxels.
  const VoxelFrame frame = volume_.frame();
  const double reach = heads_[cut.tool].reach() + edges_[cut.tool] + 4 * frame.voxel;
  const glm::ivec3 lo(glm::floor(frame.to_voxels(glm::min(cut.X_WA.p, cut.X_WB.p) - reach) / 8.0));
  const glm::ivec3 hi(glm::floor(frame.to_voxels(glm::max(cut.X_WA.p, cut.X_WB.p) + reach) / 8.0));
  Stroke* const stroke = in_stroke_ ? &done_.back() : nullptr;
  for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
    unseen_.insert({x, y, z});
    if (stroke) stroke->blocks.insert({x, y, z});
  });
  if (!stroke) return;
  for (std::size_t t = 0; t < done.removed.size(); ++t) stroke->removed[t] += done.removed[t];
}

/// Adds new brush strokes of the user to the list of strokes, in the order of time, so that undo() reverts the latest
/// stroke. A brush stroke changes only the distance field.
void VertexBody::count_painted() {
  const std::size_t kept = volume_.strokes().done - strokes_before_;
  auto known = static_cast<std::size_t>(std::ranges::count_if(done_, &Stroke::painted));
  if (kept > known) {
    end_stroke();
    undone_.clear();
    for (; known < kept; ++known) done_.emplace_back().painted = true;
  }
  // Removes, from the end of the list, the brush strokes that are no longer in the volume.
  while (known > kept && done_.back().painted) done_.pop_back(), --known;
}

void VertexBody::begin_stroke() {
  count_painted();
  volume_.end_stroke();
  end_stroke();
  undone_.clear();
  mesh_.record(&done_.emplace_back().record);
  in_stroke_ = true;
}

void VertexBody::end_stroke() {
  if (!in_stroke_) return;
  in_stroke_ = false;
  mesh_.record(nullptr);
  if (done_.back().record.empty()) done_.pop_back();
}

void VertexBody::exchange(Stroke& stroke, double sign) {
  if (stroke.painted) {
    sign > 0 ? volume_.undo() : volume_.redo();
    return;
  }
  mesh_.exchange(stroke.record);
  for (std::size_t t = 0; t < taken_back_.size(); ++t) taken_back_[t] += sign * stroke.removed[t];
  unseen_.insert(stroke.blocks.begin(), stroke.blocks.end());
}

bool VertexBody::undo() {
  count_painted();
  return move_last(done_, undone_, [&](Stroke& stroke) { exchange(stroke, 1); });
}

bool VertexBody::redo() {
  count_painted();
  return move_last(undone_, done_, [&](Stroke& stroke) { exchange(stroke, -1); });
}

TissueVolume::Strokes VertexBody::strokes() {
  count_painted();
  TissueVolume::Strokes strokes{done_.size(), undone_.size(), 0};
  for (const auto* list : {&done_, &undone_})
    for (const Stroke& stroke : *list)
      strokes.bytes += stroke.record.vertices.size() * sizeof(stroke.record.vertices[0]) +
                       stroke.record.faces.size() * sizeof(stroke.record.faces[0]);
  return strokes;
}

std::unique_ptr<Snapshot> VertexBody::make_snapshot() const {
  auto snapshot = std::make_unique<VertexSnapshot>();
  snapshot->mesh = mesh_;
  snapshot->cutter = MeshCutter(mesh_, labels_);
  snapshot->sample_of.resize(mesh_.vertex_capacity());
  return snapshot;
}

void VertexBody::cut_out(Snapshot& snapshot, std::uint32_t /*held*/) {
  auto& fresh = static_cast<VertexSnapshot&>(snapshot);
  fresh.mesh = mesh_;
  if (fresh.sample_of.size() == mesh_.vertex_capacity()) return;
  // The first snapshot that the servo returns is empty and has no buffers for cutting, so they are allocated here.
  fresh.cutter = MeshCutter(mesh_, labels_);
  fresh.sample_of.resize(mesh_.vertex_capacity());
}

void VertexBody::remember_writes(bool wanted) {
  remembers_ = wanted;
  written_.clear();
}

/// Repeats on the snapshot's mesh the cuts since remember_writes(true); this mesh is then bit-identical to the
/// carver's.
void VertexBody::bring_up_to_date(Snapshot& snapshot) {
  auto& copy = static_cast<VertexSnapshot&>(snapshot);
  for (const Cut& cut : written_) make(copy.mesh, copy.cutter, cut);
  written_.clear();
}

TissueVolume& VertexBody::rasterize() {
  if (unseen_.empty()) return volume_;
  // Ends an unfinished brush stroke, so that the following changes do not belong to this stroke when it is undone.
  volume_.end_stroke();
  for (const RasterBlock& block : field_of(mesh_, unseen_, untouched_, volume_)) volume_.replace(block);
  unseen_.clear();
  return volume_;
}

TissueSurface* VertexBody::surface() {
  if (!pieces_) pieces_.emplace(mesh_, untouched_);
  return &*pieces_;
}

}  // namespace typodont::haptics::vertex
