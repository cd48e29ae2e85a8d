// The carver's part of the contact model "mesh_lod": meshes of all levels of detail, and the mesh that cuts change.
#pragma once

#include <optional>
#include <span>

#include "haptics/contact/mesh_lod/mesh_lod_parts.h"
#include "haptics/contact/tissue_body.h"
#include "haptics/contact/vertex/vertex_body.h"

namespace typodont::haptics::mesh_lod {

/// The geometry thread of paper S3. Cuts move and split faces of the finest level, as in "vertex"; 30 times per second
/// the servo receives the faces around the tool.
class MeshLodBody final : public TissueBody {
 public:
  /// Throws Error if the tissue has no surface.
  MeshLodBody(TissueVolume tissue, std::span<const Tool> tools, const Parameters& parameters);

  void carve(const Cut& cut, bool continues) override;
  std::vector<LoosePiece> take_pieces() override { return {}; }
  void begin_stroke() override { solid_->begin_stroke(); }
  void end_stroke() override { solid_->end_stroke(); }
  bool undo() override { return edited(solid_->undo()); }
  bool redo() override { return edited(solid_->redo()); }
  PerTissue taken_back() const override { return solid_->taken_back(); }
  TissueVolume::Strokes strokes() override { return solid_->strokes(); }
  std::unique_ptr<Snapshot> make_snapshot() const override { return std::make_unique<MeshSnapshot>(); }
  double travel() const override { return travel_; }
  bool wants_snapshot(Nanos t) const override;
  void cut_out(Snapshot& snapshot, std::uint32_t held) override;
  void remember_writes(bool) override {}
  void bring_up_to_date(Snapshot& snapshot) override { cut_out(snapshot, 0); }
  TissueVolume& rasterize() override { return solid_->rasterize(); }
  TissueSurface* surface() override { return solid_->surface(); }
  std::uint64_t elements() const override { return solid_->elements(); }

  const mesh::EditableMesh& mesh() const { return solid_->mesh(); }

 private:
  void list_points(MeshSnapshot& out);
  bool edited(bool done) {
    cut_ = cut_ || done;
    return done;
  }

  std::shared_ptr<const Levels> levels_;
  std::optional<vertex::VertexBody> solid_;
  // m. travel_: distance that the tool may move until the next snapshot. reach_: largest distance of a point of any
  // tool from the origin of the tool's frame T.
  double travel_, reach_ = 0;
  bool cut_ = false;            // true: the tissue was cut
  std::optional<Nanos> first_;  // ns, time of the first cut since the last snapshot
  // for each tool: its head if contact is computed for the whole head, otherwise empty
  std::vector<std::optional<vertex::VertexHead>> heads_;
  std::unique_ptr<HeadLister> lister_;          // null: no tool needs contact points of its whole head
  std::uint32_t tool_ = MeshSnapshot::kNoTool;  // index of the tool that made the last cut
  Pose X_W_;                                    // pose of the tool after the last cut
};

}  // namespace typodont::haptics::mesh_lod
