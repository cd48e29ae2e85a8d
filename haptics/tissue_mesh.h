// Tissue as a triangle mesh: from a file, or from the surface of a volume. Frame W.
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
  std::vector<dvec3> vertices;        // m
  std::vector<glm::uvec3> triangles;  // counter-clockwise seen from outside
  std::vector<Tissue> tissue;         // tissue under each triangle
};

/// Returns the tissue's surface as a mesh, for contact models that work on meshes. If the volume was made from a mesh
/// (TissueVolume::mesh), returns that mesh. Otherwise returns the zero set of its distance field, with one or two
/// triangles per cell of the grid, each with the tissue half a voxel below it. Set-up time; empty if there is no
/// tissue.
TissueMesh surface_mesh(const TissueVolume& volume);

}  // namespace typodont::haptics
