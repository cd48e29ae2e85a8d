// Divides an editable mesh into pieces for pictures. It lists the pieces that changed, and only these are generated
// again.
#pragma once

#include <unordered_map>
#include <vector>

#include "haptics/mesh/editable_mesh.h"
#include "haptics/tissue_surface.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics::mesh {

/// Parameters of the pieces: their size, and the angle from which an edge is drawn as sharp.
struct PieceParameters {
  double faces = 256;  // wanted mean number of faces per piece
  // m, smallest edge of the cubic cells (the faces in one cell form a piece); it limits the number of pieces that are
  // drawn
  double least = 1.5e-3;
  // m, largest edge of the cubic cell of a piece; it limits the number of faces to generate again after a small cut
  double most = 3e-3;
  // Cosine of 40°. If the normals of two faces differ by more than 40°, their edge is drawn as sharp (a crease).
  double crease_cosine = 0.76604;
};

/// The pieces of a mesh. Carver thread only. The mesh and the volume must exist longer than this object.
///
/// The normal at a corner of a face is a weighted mean over faces around the corner's vertex. These are the faces that
/// can be reached from the corner's own face without crossing a crease. The weight of a face is the sine of its angle
/// at the vertex, divided by the lengths of its two edges there (Max 1999, doi 10.1080/10867651.1999.10487501: exact on
/// a sphere). So round surfaces look round at any resolution, and edges stay sharp.
class SurfacePieces final : public TissueSurface {
 public:
  /// Makes the pieces. `labels` is the volume that the function labels() returns. The positions of the pieces' corners
  /// are relative to the origin of this volume's frame. From now on, the mesh lists its changes.
  SurfacePieces(EditableMesh& mesh, const TissueVolume& labels, const PieceParameters& parameters = {});

  bool open() const override { return open_; }
  std::vector<SurfacePiece> take_changed() override;
  TissueMesh mesh() const override { return mesh_.copy(); }
  const TissueVolume& labels() const override { return labels_; }

 private:
  struct Piece {
    glm::ivec3 cell{0};
    std::vector<Index> faces;  // faces of the piece; the list may also contain faces that have moved to another piece
    bool dirty = false;
  };
  struct KeyHash {
    std::size_t operator()(const glm::ivec3& k) const noexcept;
  };
  /// The normal of a face's corner at a vertex. Different faces can have different normals at the same vertex.
  struct CornerNormal {
    Index face = kNone;
    glm::vec3 n{0};
  };
  /// Data of a vertex while a piece is generated.
  struct Local {
    // value of stamp_ when these data were computed; they are valid if it is equal to the present stamp_
    std::uint32_t stamp = 0;
    std::uint32_t first = 0, count = 0;  // range of the vertex's normals in normals_
    // index of the newest corner of the piece at this vertex; older corners follow by Copy::older
    std::uint32_t copy = 0;
  };
  /// A corner of the piece. `older` is the index of the corner that was made before it at the same vertex.
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

  // Counts the pieces that were generated. The data of a vertex in locals_ are valid only if their stamp has this
  // value.
  std::uint32_t stamp_ = 0;
  std::vector<Local> locals_;  // data of each vertex
  std::vector<CornerNormal> normals_;
  std::vector<Copy> copies_;
};

}  // namespace typodont::haptics::mesh
