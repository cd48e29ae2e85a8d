// Reads the surface of an intraoral scan, repairs it and closes it. Not for real-time threads; throws Error.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "haptics/import/import.h"
#include "haptics/import/mesh.h"

namespace typodont::haptics::importing {

struct ArchSurface {
  Mesh mesh;  // a closed mesh whose triangles face outward
  // Number of triangles of the scanned surface, including closed holes. They come first in the mesh; the triangles of
  // the base follow.
  std::size_t scanned = 0;
  // Unit vector towards the teeth: it points away from the border of an open scan, or away from the flat base of a
  // closed mesh. Zero if the direction is unknown.
  dvec3 up{0};
  std::vector<std::string> repairs;  // descriptions of the repairs of the mesh, for the user
  std::vector<dvec3> repaired;       // m, points at which the mesh was repaired (MeshRepairs::places)
};

/// Reads an intraoral scan, which may be open. Loose pieces are removed, holes are closed, and a
/// base is added below the longest border. Of `options`, the function uses only mesh_unit and
/// mesh_pose.
ArchSurface read_arch(const std::filesystem::path& file, const ImportOptions& options);

}  // namespace typodont::haptics::importing
