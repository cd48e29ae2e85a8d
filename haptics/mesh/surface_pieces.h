// An editable mesh in pieces, as pictures need it. Keeps the list of what changed, and makes those pieces anew.
#pragma once

#include <unordered_map>
#include <vector>

#include "haptics/mesh/editable_mesh.h"
#include "haptics/tissue_surface.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics::mesh {

/// What the pieces are like.
struct PieceParameters {
  double faces = 256;              // that a piece should have
  double least = 1.5e-3;           // m, edge of a piece's cell: fewer pieces to draw …
  double most = 3e-3;              // m: … and fewer faces to make anew for a small cut
  double crease_cosine = 0.76604;  // cos 40°: an edge whose faces' normals differ by more is drawn sharp
};

/// Carver thread. Mesh and volume outlive it.
///
/// Normals: a corner's is the mean over the faces around its vertex that can be reached from its own face without
/// crossing a crease, each weighted by sin(angle) over the lengths of its two edges there (Max 1999, doi
/// 10.1080/10867651.1999.10487501: exact on a sphere). So round places look round at any fineness, and edges stay
/// sharp.
class SurfacePieces final : public TissueSurface {
 public:
  /// `labels`: what labels() gives; places of corners start from its frame's origin. From now on the mesh lists its
  /// changes.
  SurfacePieces(EditableMesh& mesh, const TissueVolume& labels, const PieceParameters& parameters = {});

  bool open() const override { return open_; }
  std::vector<SurfacePiece> take_changed() override;
  TissueMesh mesh() const override { return mesh_.copy(); }
  const TissueVolume& labels() const override { return labels_; }

 private:
  struct Piece {
    glm::ivec3 cell{0};
    std::vector<Index> faces;  // and some that have left it
    bool dirty = false;
  };
  struct KeyHash {
    std::size_t operator()(const glm::ivec3& k) const noexcept;
  };
  /// A face at a vertex, with the normal there.
  struct CornerNormal {
    Index face = kNone;
    glm::vec3 n{0};
  };
  /// A vertex of the piece that is being made.
  struct Local {
    std::uint32_t stamp = 0;             // of the piece that it was last part of
    std::uint32_t first = 0, count = 0;  // of normals_
    std::uint32_t copy = 0;              // its newest corner in the piece
  };
  /// A corner of the piece: the one made before it of the same vertex.
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
  std::vector<std::uint32_t> piece_of_;  // by face
  std::vector<std::uint32_t> dirty_;
  std::vector<Index> changes_;

  // Of the piece that is being made.
  std::uint32_t stamp_ = 0;
  std::vector<Local> locals_;  // by vertex
  std::vector<CornerNormal> normals_;
  std::vector<Copy> copies_;
};

}  // namespace typodont::haptics::mesh
