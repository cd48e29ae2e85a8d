// Meshes, also open, as tissue and volume. Not for real time.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/json.h"
#include "haptics/dense_tissue.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics {

/// "mesh" of a scene: {"file", "unit_mm", "move_mm", "tissue", "voxel_mm"}.
struct MeshTissueOptions {
  std::string file;    // name of the file as the scene states it
  double unit = 1e-3;  // length in m of one unit of the file
  dvec3 move{0};       // m, displacement that is added to all points
  Tissue tissue = Tissue::kEnamel;
  // m; empty: 0.1 mm or more
  std::optional<double> voxel;
};
/// Throws Error.
MeshTissueOptions read_mesh_tissue_options(const Json& mesh);

struct ReadTissueMesh {
  TissueMesh mesh;
  std::vector<std::string> repairs;  // descriptions of the repairs, for the user
};
/// Reads a mesh (STL, PLY, OBJ, .gltf, .glb). Open borders, edges with more than two triangles and surfaces that cross
/// themselves are allowed. Corners at the same position become one vertex. Triangles with two equal corners and second
/// copies of triangles are removed. A closed mesh whose triangles enclose a negative volume is reversed. Throws Error
/// for an empty file, no triangles, coordinates that are not finite, indices out of range, or more than 10 million
/// triangles.
ReadTissueMesh read_tissue_mesh(const std::filesystem::path& file, double unit, Tissue tissue);
/// `file`: path of options.file. Throws Error.
ReadTissueMesh read_tissue_mesh(const std::filesystem::path& file, const MeshTissueOptions& options);

/// Winding number ≥ 0.5 along the six axes. Open: capped, `exact_outside` false. No volume: a shell of two voxels.
/// Throws Error for lack of memory.
DenseTissue rasterize(const TissueMesh& mesh, const MeshTissueOptions& options);

}  // namespace typodont::haptics
