// The drawn surface as one mesh file. Throws Error.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/partial_file.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "engine/surface/surface_mesher.h"

namespace typodont::surface {

/// All bricks, coincident points merged. Voxels.
struct WholeMesh {
  struct Vertex {
    glm::vec3 position{0};
    glm::vec3 normal{0};
    Tissue tissue = Tissue::kAir;  // the most frequent tissue around the vertex
  };
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // triangles, counter-clockwise as seen from outside
};

WholeMesh weld(const SurfaceMesher& mesher);

/// Throws Error for an unsupported extension, before long work.
void require_mesh_format(const std::filesystem::path& file);

/// Whole or not at all, W, mm: .ply (binary: normals, colours, labels), .stl (binary), .obj (text: normals, colours),
/// .glb or .gltf (normals, colours; metres, as required; axes of W).
void write_mesh(const std::filesystem::path& file, const WholeMesh& mesh, const VoxelFrame& frame,
                const MaterialTable& materials, Over over = Over::kNoInput);

}  // namespace typodont::surface
