// The surface of a body that consists of triangles, piece by piece, for pictures. Carver thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/contract/tissue.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics {

/// One corner of a piece's triangles. All corners of a triangle name the same two tissues.
struct SurfaceCorner {
  glm::vec3 p{0};        // m, from the origin of the volume's frame
  glm::vec3 n{0, 0, 1};  // unit, out of the tissue
  std::array<Tissue, 2> tissue{Tissue::kAir, Tissue::kAir};
  float second = 0;  // 0..1: share of tissue[1]; the border between the two runs where it is a half
};

/// The faces whose centroids lie in one cell of a grid in space.
struct SurfacePiece {
  glm::ivec3 cell{0};
  std::vector<SurfaceCorner> corners;
  std::vector<std::uint32_t> indices;  // triangles, counter-clockwise seen from outside; none: nothing is left of it
};

class TissueSurface {
 public:
  virtual ~TissueSurface() = default;

  /// It has a border, so that its back can be seen.
  virtual bool open() const = 0;
  /// The first time all pieces; afterwards those whose faces, normals or tissues changed since the last call. A piece
  /// depends on the mesh alone, not on how that came about.
  virtual std::vector<SurfacePiece> take_changed() = 0;
  /// All of it.
  virtual TissueMesh mesh() const = 0;
  /// The labels below the surface. Its distances are those of some earlier state.
  virtual const TissueVolume& labels() const = 0;
};

}  // namespace typodont::haptics
