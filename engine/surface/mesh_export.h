// Writes the drawn surface as a mesh file. Throws Error.
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

/// Mesh of all bricks, in which coincident points are merged. Positions in voxels.
struct WholeMesh {
  struct Vertex {
    glm::vec3 position{0};
    glm::vec3 normal{0};
    Tissue tissue = Tissue::kAir;  // the most frequent tissue around the vertex
    glm::vec4 paint{0};            // sRGB, colour mixed into the tissue's colour; w: fraction of this colour, 0 to 1
  };
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // triangles, counter-clockwise as seen from outside
};

WholeMesh weld(const SurfaceMesher& mesher);

/// Throws Error if the file's extension is not supported. Call it before long work.
void require_mesh_format(const std::filesystem::path& file);

/// Writes the mesh in frame W, mm (.glb and .gltf: m). On failure, no partial file remains. All formats but .stl
/// contain normals and colours; .ply also contains tissue labels. .ply and .stl are binary, .obj is text.
void write_mesh(const std::filesystem::path& file, const WholeMesh& mesh, const VoxelFrame& frame,
                const MaterialTable& materials, Over over = Over::kNoInput);

}  // namespace typodont::surface
