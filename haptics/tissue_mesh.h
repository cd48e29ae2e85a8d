// Tissue as a triangle mesh: from a file, or from the surface of a volume. Frame W.
#pragma once

#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont::haptics {

struct TissueMesh {
  std::vector<dvec3> vertices;        // m
  std::vector<glm::uvec3> triangles;  // counter-clockwise seen from outside
  std::vector<Tissue> tissue;         // of each triangle: the tissue under it
};

}  // namespace typodont::haptics
