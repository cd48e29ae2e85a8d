// Writes the drawn surface as one mesh file for other programs. The functions throw Error.
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

/// The triangles of all bricks (blocks of 16³ cells), with coincident points merged. Lengths in voxels.
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

/// Checks a file name. Throws Error with the file name if write_mesh() does not support the extension. Call this
/// function before long work.
void require_mesh_format(const std::filesystem::path& file);

/// Writes the file completely or not at all, in frame W. The extension selects the format: .ply (binary, with normals,
/// colours and tissue labels), .stl (binary), .obj (text, with normals and vertex colours), .glb (glTF 2.0, binary,
/// with normals and vertex colours) or .gltf (the same as JSON, with all data in the file). Lengths are millimetres.
/// Only glTF files have metres, as their format requires; their axes are those of W, although viewers show y upwards.
void write_mesh(const std::filesystem::path& file, const WholeMesh& mesh, const VoxelFrame& frame,
                const MaterialTable& materials, Over over = Over::kNoInput);

}  // namespace typodont::surface
