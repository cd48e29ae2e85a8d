// The triangle surface of a tissue body, divided into pieces for the renderer. Carver thread only.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/contract/tissue.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics {

/// One corner of a triangle. A triangle has two tissues, which are stored in each of its three corners.
struct SurfaceCorner {
  glm::vec3 p{0};        // m, position relative to the origin of the volume's frame
  glm::vec3 n{0, 0, 1};  // unit normal, pointing out of the tissue
  std::array<Tissue, 2> tissue{Tissue::kAir, Tissue::kAir};
  // fraction 0..1 of tissue[1] at this corner; the renderer draws the border of the two tissues where the value is 0.5
  float second = 0;
};

/// Faces whose centroids lie in one grid cell.
struct SurfacePiece {
  glm::ivec3 cell{0};
  std::vector<SurfaceCorner> corners;
  // triangles, counter-clockwise seen from outside; empty: the piece does not exist any more
  std::vector<std::uint32_t> indices;
};

class TissueSurface {
 public:
  virtual ~TissueSurface() = default;

  /// Returns true if the surface has an open border, so that its inner side can be visible.
  virtual bool open() const = 0;
  /// Returns all pieces in the first call, and later those that have changed since the last call. A piece depends only
  /// on the current mesh, not on its history.
  virtual std::vector<SurfacePiece> take_changed() = 0;
  /// Whole surface as one mesh.
  virtual TissueMesh mesh() const = 0;
  /// Volume with the labels below the surface. Its distances may be out of date.
  virtual const TissueVolume& labels() const = 0;
};

}  // namespace typodont::haptics
