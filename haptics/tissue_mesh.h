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
  std::vector<Tissue> tissue;         // tissue below each triangle
};

/// Returns the tissue's surface as a mesh, for contact models that use meshes. If the volume was made from a mesh
/// (TissueVolume::mesh), returns that mesh. Otherwise returns the zero set of its distance field, with one or two
/// triangles per grid cell; the label of each triangle is that of the tissue half a voxel below it. Empty if there is
/// no tissue. Not for the servo thread.
TissueMesh surface_mesh(const TissueVolume& volume);

}  // namespace typodont::haptics
