// The carver's half of "vertex": the mesh, its strokes, and the field that is made of it.
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

/// The whole mesh, with what it takes to cut it.
struct VertexSnapshot final : Snapshot {
  mesh::EditableMesh mesh;
  MeshCutter cutter;
  std::vector<std::uint32_t> sample_of;  // of a vertex: where the model lists it
};

struct KeyLess {
  bool operator()(const glm::ivec3& a, const glm::ivec3& b) const {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  }
};
/// Blocks of 8³ samples of the field, by their number along each axis.
using FieldBlocks = std::set<glm::ivec3, KeyLess>;

/// Carver thread. Cuts are made in the mesh alone; the field follows when it is asked for.
class VertexBody final : public TissueBody {
 public:
  VertexBody(TissueVolume tissue, const TissueMesh& mesh, std::span<const Tool> tools, const Parameters& parameters);

  void carve(const Cut& cut, bool continues) override;
  /// Never called: the model refuses tools that fill.
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
  /// m³ that cuts removed so far, undone ones included.
  const PerTissue& removed() const { return removed_; }

 private:
  struct Stroke {
    mesh::MeshRecord record;
    PerTissue removed{};   // m³
    FieldBlocks blocks;    // that it may have changed
    bool painted = false;  // it is one of the brush's, which the field alone keeps
  };
  CutDone make(mesh::EditableMesh& mesh, MeshCutter& cutter, const Cut& cut) const;
  void exchange(Stroke& stroke, double sign);
  void count_painted();

  TissueVolume volume_;
  std::size_t strokes_before_;  // that the volume came with, which the mesh knows nothing of
  TissueVolume untouched_;
  Parameters parameters_;
  std::vector<VertexHead> heads_;
  std::vector<double> edges_;  // m, that each of them asks for
  mesh::EditableMesh mesh_;
  MeshCutter cutter_;
  SharedLabels labels_;
  std::deque<Stroke> done_, undone_;
  bool in_stroke_ = false;
  PerTissue removed_{}, taken_back_{};
  bool remembers_ = false;
  std::vector<Cut> written_;                   // since remember_writes(true)
  FieldBlocks unseen_;                         // that the field does not show yet
  std::optional<mesh::SurfacePieces> pieces_;  // for pictures, once they were asked for
};

/// The cut that `cut` tells of; servo and carver both call it and hold the same bits.
inline CutDone make_cut(mesh::EditableMesh& mesh, MeshCutter& cutter, const VertexHead& head, double edge,
                        bool as_printed, const Pose& X_WA, const Pose& X_WB) noexcept {
  return as_printed ? cutter.cut_as_printed(mesh, head, X_WB) : cutter.cut(mesh, head, X_WA, X_WB, edge);
}

}  // namespace typodont::haptics::vertex
