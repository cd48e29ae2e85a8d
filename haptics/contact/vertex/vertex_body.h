// The part of the contact model "vertex" that runs on the carver thread: the mesh, its strokes, and the field computed
// from it.
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

/// The whole mesh with the data needed to cut it.
struct VertexSnapshot final : Snapshot {
  mesh::EditableMesh mesh;
  MeshCutter cutter;
  std::vector<std::uint32_t> sample_of;  // for each vertex: index in the model's list of samples
};

struct KeyLess {
  bool operator()(const glm::ivec3& a, const glm::ivec3& b) const {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  }
};
/// Blocks of 8³ samples of the field, by their index along each axis.
using FieldBlocks = std::set<glm::ivec3, KeyLess>;

/// Carver thread. Cuts change only the mesh; the field is updated on request.
class VertexBody final : public TissueBody {
 public:
  VertexBody(TissueVolume tissue, const TissueMesh& mesh, std::span<const Tool> tools, const Parameters& parameters);

  void carve(const Cut& cut, bool continues) override;
  /// Is never called, because the model refuses filling instruments.
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
  void cut_out(Snapshot& snapshot) override;
  void remember_writes(bool wanted) override;
  void bring_up_to_date(Snapshot& snapshot) override;
  TissueVolume& rasterize() override;
  TissueSurface* surface() override;
  std::uint64_t elements() const override { return mesh_.vertex_count(); }

  const mesh::EditableMesh& mesh() const { return mesh_; }
  /// Volume removed by all cuts up to now, undone ones included, m³.
  const PerTissue& removed() const { return removed_; }

 private:
  struct Stroke {
    mesh::MeshRecord record;
    PerTissue removed{};   // m³
    FieldBlocks blocks;    // blocks that the stroke may have changed
    bool painted = false;  // true: the stroke painted tissue, which only the field stores
  };
  CutDone make(mesh::EditableMesh& mesh, MeshCutter& cutter, const Cut& cut) const;
  void exchange(Stroke& stroke, double sign);
  void count_painted();

  TissueVolume volume_;
  std::size_t strokes_before_;  // number of strokes that the volume had at the start; the mesh does not contain them
  TissueVolume untouched_;
  Parameters parameters_;
  std::vector<VertexHead> heads_;
  std::vector<double> edges_;  // m, edge length required by each head
  mesh::EditableMesh mesh_;
  MeshCutter cutter_;
  SharedLabels labels_;
  std::deque<Stroke> done_, undone_;
  bool in_stroke_ = false;
  PerTissue removed_{}, taken_back_{};
  bool remembers_ = false;
  std::vector<Cut> written_;                   // cuts since remember_writes(true)
  FieldBlocks unseen_;                         // blocks that changed, but are not updated in the field yet
  std::optional<mesh::SurfacePieces> pieces_;  // surface for pictures; created at the first request
};

/// Executes a cut. Servo and carver call this function, so both get the same bits.
inline CutDone make_cut(mesh::EditableMesh& mesh, MeshCutter& cutter, const VertexHead& head, double edge,
                        bool as_printed, const Pose& X_WA, const Pose& X_WB) noexcept {
  return as_printed ? cutter.cut_as_printed(mesh, head, X_WB) : cutter.cut(mesh, head, X_WA, X_WB, edge);
}

}  // namespace typodont::haptics::vertex
