// The triangle surface of a tissue body in pieces, for pictures. Carver thread.
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
  glm::vec3 p{0};        // m, position relative to the origin of the volume's frame
  glm::vec3 n{0, 0, 1};  // unit normal, pointing out of the tissue
  std::array<Tissue, 2> tissue{Tissue::kAir, Tissue::kAir};
  float second = 0;  // 0..1, fraction of tissue[1]; the border between the two tissues is drawn where this value is 0.5
};

/// The faces whose centroids are in one cell of a spatial grid.
struct SurfacePiece {
  glm::ivec3 cell{0};
  std::vector<SurfaceCorner> corners;
  std::vector<std::uint32_t> indices;  // triangles, counter-clockwise seen from outside; empty: the piece is empty now
};

class TissueSurface {
 public:
  virtual ~TissueSurface() = default;

  /// True if the surface has a border, so that its back can be seen.
  virtual bool open() const = 0;
  /// The first call returns all pieces, later calls the pieces whose faces, normals or tissues changed since the last
  /// call. A piece depends only on the mesh, not on the mesh's history.
  virtual std::vector<SurfacePiece> take_changed() = 0;
  /// The whole surface as one mesh.
  virtual TissueMesh mesh() const = 0;
  /// The labels below the surface. The distances of this volume may be older than the surface.
  virtual const TissueVolume& labels() const = 0;
};

}  // namespace typodont::haptics
