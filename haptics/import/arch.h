// Reads the surface of an intraoral scan, repairs it and closes it with a base. Not for real time; throws Error.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "haptics/import/import.h"
#include "haptics/import/mesh.h"

namespace typodont::haptics::importing {

struct ArchSurface {
  Mesh mesh;  // the closed surface; its triangles face outward
  // Number of triangles of the scanned surface and of its closed holes. The triangles of the base follow them.
  std::size_t scanned = 0;
  // Unit vector towards the teeth, away from the scan's border or flat base; zero if unknown.
  dvec3 up{0};
  std::vector<std::string> repairs;  // descriptions of the repairs of the mesh, for the user
  std::vector<dvec3> repaired;       // points at which the mesh was repaired, m (MeshRepairs::places)
};

/// Removes loose pieces, closes holes, and adds a base below the longest border. Uses only the options mesh_unit and
/// mesh_pose.
ArchSurface read_arch(const std::filesystem::path& file, const ImportOptions& options);

}  // namespace typodont::haptics::importing
