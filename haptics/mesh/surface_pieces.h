// Divides a mesh into pieces for rendering, and generates changed pieces again.
#pragma once

#include <unordered_map>
#include <vector>

#include "engine/base/voxels.h"
#include "haptics/mesh/editable_mesh.h"
#include "haptics/mesh/tissue_surface.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics::mesh {

struct PieceParameters {
  double faces = 256;  // wanted mean number of faces per piece
  // m, smallest edge of a grid cell; smaller cells give too many pieces
  double least = 1.5e-3;
  // m, largest edge of a grid cell; larger cells make every cut slower
  double most = 3e-3;
  // cos 40°; a larger angle makes a crease
  double crease_cosine = 0.76604;
};

/// Carver thread only; mesh and volume must outlive it. A corner's normal is the mean over faces up to the next crease,
/// weighted by sin(angle) / product of the edges (Max 1999, doi 10.1080/10867651.1999.10487501).
class SurfacePieces final : public TissueSurface {
 public:
  /// `labels`: volume that labels() returns; corners are relative to its origin. From now on, the mesh lists its
  /// changes.
  SurfacePieces(EditableMesh& mesh, const TissueVolume& labels, const PieceParameters& parameters = {});

  bool open() const override { return open_; }
  std::vector<SurfacePiece> take_changed() override;
  TissueMesh mesh() const override { return mesh_.copy(); }
  const TissueVolume& labels() const override { return labels_; }

 private:
  struct Piece {
    glm::ivec3 cell{0};
    std::vector<Index> faces;  // faces of the piece; may contain faces that have moved to other pieces
    bool dirty = false;
  };
  /// Normal of a face at a vertex; it differs between the faces around the vertex.
  struct CornerNormal {
    Index face = kNone;
    glm::vec3 n{0};
  };
  /// Data of a vertex while a piece is generated.
  struct Local {
    // the data are valid if `stamp` equals stamp_
    std::uint32_t stamp = 0;
    std::uint32_t first = 0, count = 0;  // range of the vertex's normals in normals_
    // index of this vertex's newest corner; each corner's Copy::older is the index of the corner made before it
    std::uint32_t copy = 0;
  };
  /// `older`: corner that was made before at the same vertex.
  struct Copy {
    std::uint32_t older;
  };

  std::uint32_t piece_at(Index f);
  void mark(std::uint32_t piece);
  void put(Index f);
  void look_around(Index v);
  SurfacePiece make(Piece& piece);

  EditableMesh& mesh_;
  const TissueVolume& labels_;
  const dvec3 origin_;
  const PieceParameters parameters_;
  double cell_;
  bool open_;
  std::vector<Piece> pieces_;
  std::unordered_map<glm::ivec3, std::uint32_t, KeyHash> by_cell_;
  std::vector<std::uint32_t> piece_of_;  // for each face: number of its piece
  std::vector<std::uint32_t> dirty_;
  std::vector<Index> changes_;

  // number of pieces generated so far; shows which elements of locals_ are valid
  std::uint32_t stamp_ = 0;
  std::vector<Local> locals_;  // data of each vertex
  std::vector<CornerNormal> normals_;
  std::vector<Copy> copies_;
};

}  // namespace typodont::haptics::mesh
