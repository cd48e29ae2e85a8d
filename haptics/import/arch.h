// Reads, repairs and closes the surface of an intraoral scan. Not for real time; throws Error.
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
  // Triangles of the scanned surface with closed holes; those of the base follow.
  std::size_t scanned = 0;
  // Unit vector to the teeth, away from the border or the flat base; zero: unknown.
  dvec3 up{0};
  std::vector<std::string> repairs;  // descriptions of the repairs of the mesh, for the user
  std::vector<dvec3> repaired;       // m, points at which the mesh was repaired (MeshRepairs::places)
};

/// Removes loose pieces, closes holes, adds a base below the longest border. Of `options`: mesh_unit and mesh_pose.
ArchSurface read_arch(const std::filesystem::path& file, const ImportOptions& options);

}  // namespace typodont::haptics::importing
