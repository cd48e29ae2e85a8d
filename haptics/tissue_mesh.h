// Tissue as a triangle mesh: from a file, or from the surface of a volume. Workbench frame W.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont::haptics {

class TissueVolume;

struct TissueMesh {
  std::vector<dvec3> vertices;        // m, positions of the vertices
  std::vector<glm::uvec3> triangles;  // counter-clockwise seen from outside
  std::vector<Tissue> tissue;         // tissue directly below each triangle
};

/// Returns the tissue's surface as a mesh: the source mesh (TissueVolume::mesh), or else the zero set of the distance
/// field. Labels are read half a voxel below the surface. Not for the servo thread.
TissueMesh surface_mesh(const TissueVolume& volume);

}  // namespace typodont::haptics
