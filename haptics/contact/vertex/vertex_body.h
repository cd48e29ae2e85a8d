// The part of the contact model "vertex" that runs on the carver thread. It owns the mesh, the strokes for undo, and
// the distance field that is computed from the mesh.
#pragma once

#include <deque>
#include <optional>
#include <set>
#include <span>
#include <tuple>
#include <vector>

#include "haptics/contact/vertex/mesh_cutter.h"
#include "haptics/contact/vertex/vertex_method.h"
#include "haptics/mesh/surface_pieces.h"
#include "haptics/tissue_body.h"

namespace typodont::haptics::vertex {

/// A copy of the whole mesh for the servo, with the buffers that are needed to cut it.
struct VertexSnapshot final : Snapshot {
  mesh::EditableMesh mesh;
  MeshCutter cutter;
  std::vector<std::uint32_t> sample_of;  // for each vertex: its index in the servo's list of samples (VertexModel)
};

struct KeyLess {
  bool operator()(const glm::ivec3& a, const glm::ivec3& b) const {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  }
};
/// Blocks of 8³ samples of the distance field. A block is identified by its index along each axis.
using FieldBlocks = std::set<glm::ivec3, KeyLess>;

/// The tissue as a mesh, and the distance field that is computed from the mesh. Carver thread only. A cut changes only
/// the mesh. The distance field is updated when rasterize() is called.
class VertexBody final : public TissueBody {
 public:
  VertexBody(TissueVolume tissue, const TissueMesh& mesh, std::span<const Tool> tools, const Parameters& parameters);

  void carve(const Cut& cut, bool continues) override;
  /// Never called, because the model refuses filling instruments.
  void fill(const Cut& cut) override;
  std::vector<LoosePiece> take_pieces() override { return {}; }
  void begin_stroke() override;
  void end_stroke() override;
  bool undo() override;
  bool redo() override;
  PerTissue taken_back() const override { return taken_back_; }
  TissueVolume::Strokes strokes() override;
  std::unique_ptr<Snapshot> make_snapshot() const override;
  double travel() const override;
  void cut_out(Snapshot& snapshot, std::uint32_t held) override;
  void remember_writes(bool wanted) override;
  void bring_up_to_date(Snapshot& snapshot) override;
  TissueVolume& rasterize() override;
  TissueSurface* surface() override;
  std::uint64_t elements() const override { return mesh_.vertex_count(); }

  const mesh::EditableMesh& mesh() const { return mesh_; }
  /// Returns the volume (m³) of each tissue that was removed by all cuts together, including cuts that were undone.
  const PerTissue& removed() const { return removed_; }

 private:
  struct Stroke {
    mesh::MeshRecord record;
    PerTissue removed{};   // m³, volume of each tissue that the stroke has removed
    FieldBlocks blocks;    // blocks of the distance field that the stroke may have changed
    bool painted = false;  // true: the stroke painted tissue; painting changes only the distance field
  };
  CutDone make(mesh::EditableMesh& mesh, MeshCutter& cutter, const Cut& cut) const;
  void exchange(Stroke& stroke, double sign);
  void count_painted();

  TissueVolume volume_;
  // number of strokes that the volume already contained when this object was constructed; they are not in `done_`
  std::size_t strokes_before_;
  TissueVolume untouched_;
  Parameters parameters_;
  std::vector<VertexHead> heads_;
  std::vector<double> edges_;  // m, for each head: wanted length of mesh edges on the surfaces that it cuts
  mesh::EditableMesh mesh_;
  SharedLabels labels_;
  MeshCutter cutter_;
  std::deque<Stroke> done_, undone_;
  bool in_stroke_ = false;
  PerTissue removed_{}, taken_back_{};
  bool remembers_ = false;
  std::vector<Cut> written_;  // cuts that were made since remember_writes(true) was called
  // blocks of the distance field that cuts have changed and that must be updated
  FieldBlocks unseen_;
  std::optional<mesh::SurfacePieces> pieces_;  // surface for the renderer; created at the first request
};

/// Executes a cut. Servo and carver both call this function, so their meshes stay equal bit by bit.
inline CutDone make_cut(mesh::EditableMesh& mesh, MeshCutter& cutter, const VertexHead& head, double edge,
                        bool as_printed, const Pose& X_WA, const Pose& X_WB) noexcept {
  return as_printed ? cutter.cut_as_printed(mesh, head, X_WB) : cutter.cut(mesh, head, X_WA, X_WB, edge);
}

}  // namespace typodont::haptics::vertex
