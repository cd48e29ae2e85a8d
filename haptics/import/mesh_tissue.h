// Uses triangle meshes as tissue. The meshes are read from files, may be open, and are converted to volumes. Not
// real-time.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/json.h"
#include "haptics/dense_tissue.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics {

/// Options of the object "mesh" in a scene's "tissue": {"file", "unit_mm", "move_mm", "tissue", "voxel_mm"}.
struct MeshTissueOptions {
  std::string file;    // name of the file as the scene states it
  double unit = 1e-3;  // length in m of one unit of the file
  dvec3 move{0};       // m, displacement that is added to all points
  Tissue tissue = Tissue::kEnamel;
  // m, voxel edge of the volume; if not given, 0.1 mm, or more if the volume would be too large
  std::optional<double> voxel;
};
/// Reads the options. Throws Error if a key or a value is not allowed.
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
/// Reads a mesh with the options of a scene. `file` is the path of options.file. Throws Error.
ReadTissueMesh read_tissue_mesh(const std::filesystem::path& file, const MeshTissueOptions& options);

/// Fills a mesh to a volume. A sample is inside if its generalized winding number, computed from rays in the six axis
/// directions, is 0.5 or more. For a closed mesh this is exact, even if parts overlap. An open mesh is closed by a cap,
/// and `exact_outside` is then false. A mesh that encloses no volume (a sheet) becomes a shell with a thickness of two
/// voxels. Throws Error if the volume does not fit into memory.
DenseTissue rasterize(const TissueMesh& mesh, const MeshTissueOptions& options);

}  // namespace typodont::haptics
