// Triangle meshes as tissue: read from files, open ones too, and filled to volumes. Set-up time.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/json.h"
#include "haptics/dense_tissue.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics {

/// The object "mesh" of a scene's "tissue": {"file", "unit_mm", "move_mm", "tissue", "voxel_mm"}.
struct MeshTissueOptions {
  std::string file;    // as it stands there
  double unit = 1e-3;  // m per unit of the file
  dvec3 move{0};       // m, added to all points
  Tissue tissue = Tissue::kEnamel;
  std::optional<double> voxel;  // m, of the volume; none: 0.1 mm, or as much more as the memory asks for
};
/// Throws Error.
MeshTissueOptions read_mesh_tissue_options(const Json& mesh);

struct ReadTissueMesh {
  TissueMesh mesh;
  std::vector<std::string> repairs;  // what was mended, in plain words
};
/// Reads STL, PLY, OBJ or glTF (.gltf, .glb). Open borders, edges of more than two triangles and surfaces that cross
/// themselves are accepted. Corners at the same place become one vertex; triangles with two equal corners and second
/// copies of a triangle go; a mesh whose triangles enclose a negative volume is turned. Throws Error for an empty file,
/// no triangles, coordinates that are not finite, indices out of range, more than 10 million triangles.
ReadTissueMesh read_tissue_mesh(const std::filesystem::path& file, double unit, Tissue tissue);
/// The same with a scene's options; `file`: the path of options.file. Throws Error.
ReadTissueMesh read_tissue_mesh(const std::filesystem::path& file, const MeshTissueOptions& options);

/// The volume of a mesh: inside is where its generalized winding number, taken along the six directions of the axes, is
/// a half or more. For a closed mesh that is exact, overlapping parts included; an open one is closed by a cap, of
/// which `exact_outside` is then false. A mesh that encloses nothing (a sheet) becomes a shell two voxels thick. Throws
/// Error where the volume would not fit into memory.
DenseTissue rasterize(const TissueMesh& mesh, const MeshTissueOptions& options);

}  // namespace typodont::haptics
