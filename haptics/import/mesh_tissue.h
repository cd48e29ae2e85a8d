// Triangle meshes, also open ones, as tissue mesh and volume. Not for real time.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/json.h"
#include "haptics/dense_tissue.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics {

/// Options of the key "mesh" of a scene: {"file", "unit_mm", "move_mm", "tissue", "voxel_mm"}.
struct MeshTissueOptions {
  std::string file;    // name of the file as the scene states it
  double unit = 1e-3;  // length in m of one unit of the file
  dvec3 move{0};       // m, displacement that is added to all points
  Tissue tissue = Tissue::kEnamel;
  // Voxel edge, m; empty: 0.1 mm, or more for a large mesh.
  std::optional<double> voxel;
};
/// Reads the options of a scene. Throws Error.
void describe_mesh_tissue(Keys& keys, MeshTissueOptions& options);
MeshTissueOptions read_mesh_tissue_options(const Json& mesh);

struct ReadTissueMesh {
  TissueMesh mesh;
  std::vector<std::string> repairs;  // descriptions of the repairs, for the user
};
/// Reads a mesh (STL, PLY, OBJ, .gltf, .glb), which may be open or cross itself. Merges equal corners, removes
/// degenerate triangles and copies, and reverses an inverted mesh. Throws Error for an invalid file or more than 10
/// million triangles.
ReadTissueMesh read_tissue_mesh(const std::filesystem::path& file, double unit, Tissue tissue);
/// `file`: resolved path of options.file. Throws Error.
ReadTissueMesh read_tissue_mesh(const std::filesystem::path& file, const MeshTissueOptions& options);

/// Voxels with winding number ≥ 0.5 (rays along six directions) are inside. Openings of the mesh are closed, and
/// `exact_outside` is then false. A mesh without volume becomes a shell. Throws Error if memory is too small.
DenseTissue rasterize(const TissueMesh& mesh, const MeshTissueOptions& options);

}  // namespace typodont::haptics
