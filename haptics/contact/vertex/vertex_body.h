// The carver's part of the contact model "vertex": mesh, undo, and the distance field computed from the mesh.
#pragma once

#include <deque>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "engine/base/voxels.h"
#include "haptics/contact/tissue_body.h"
#include "haptics/contact/vertex/mesh_cutter.h"
#include "haptics/contact/vertex/vertex_method.h"
#include "haptics/mesh/surface_pieces.h"

namespace typodont::haptics::vertex {

/// The servo's mesh, with the buffers for cutting it.
struct VertexSnapshot final : Snapshot {
  mesh::EditableMesh mesh;
  MeshCutter cutter;
  std::vector<std::uint32_t> sample_of;  // for each vertex: its index in the samples of VertexModel
};

/// Blocks of 8³ samples; a key is the index of a block along each axis.
using FieldBlocks = std::set<glm::ivec3, LessByAxes>;

/// Carver thread only. Cuts change only the mesh; rasterize() then updates the distance field.
class VertexBody final : public TissueBody {
 public:
  VertexBody(TissueVolume tissue, const TissueMesh& mesh, std::span<const Tool> tools, const Parameters& parameters);

  void carve(const Cut& cut, bool continues) override;
  std::vector<LoosePiece> take_pieces() override { return {}; }
  void begin_stroke() override;
  void end_stroke() override;
  bool undo() override;
  bool redo() override;
  PerTissue taken_back() const override { return taken_back_; }
  TissueVolume::Strokes strokes() override;
  std::unique_ptr<Snapshot> make_snapshot() const override;
  void cut_out(Snapshot& snapshot, std::uint32_t held) override;
  void remember_writes(bool wanted) override;
  void bring_up_to_date(Snapshot& snapshot) override;
  TissueVolume& rasterize() override;
  TissueSurface* surface() override;
  std::uint64_t elements() const override { return mesh_.vertex_count(); }

  const mesh::EditableMesh& mesh() const { return mesh_; }
  /// Volume removed by all cuts, including cuts that were undone, m³.
  const PerTissue& removed() const { return removed_; }

 private:
  struct Stroke {
    mesh::MeshRecord record;
    PerTissue removed{};   // m³, removed volume of each tissue
    FieldBlocks blocks;    // blocks of the field that the stroke may have changed
    bool painted = false;  // true: a stroke of painting, which changes only the field
  };
  CutDone make(mesh::EditableMesh& mesh, MeshCutter& cutter, const Cut& cut) const;
  void exchange(Stroke& stroke, double sign);
  void count_painted();

  TissueVolume volume_;
  // number of strokes that the volume contained at construction; these are not in `done_`
  std::size_t strokes_before_;
  TissueVolume untouched_;
  Parameters parameters_;
  std::vector<VertexHead> heads_;
  std::vector<double> edges_;  // m, target edge length for each head
  mesh::EditableMesh mesh_;
  SharedLabels labels_;
  MeshCutter cutter_;
  std::deque<Stroke> done_, undone_;
  bool in_stroke_ = false;
  PerTissue removed_{}, taken_back_{};
  bool remembers_ = false;
  std::vector<Cut> written_;  // cuts that were made since remember_writes(true) was called
  // blocks of the distance field that must be updated
  FieldBlocks unseen_;
  std::optional<mesh::SurfacePieces> pieces_;  // triangles for the renderer; created at the first request
};

/// Cuts the mesh; the result is bit-identical on servo and carver.
inline CutDone make_cut(mesh::EditableMesh& mesh, MeshCutter& cutter, const VertexHead& head, double edge,
                        bool as_printed, const Pose& X_WA, const Pose& X_WB) noexcept {
  return as_printed ? cutter.cut_as_printed(mesh, head, X_WB) : cutter.cut(mesh, head, X_WA, X_WB, edge);
}

}  // namespace typodont::haptics::vertex
