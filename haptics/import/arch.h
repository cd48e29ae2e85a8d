// The surface of an intraoral scan, repaired and closed. Set-up time; throws Error.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "haptics/import/import.h"
#include "haptics/import/mesh.h"

namespace typodont::haptics::importing {

struct ArchSurface {
  Mesh mesh;  // closed; the triangles face outward
  // number of triangles of the scan and of its closed holes; the base's triangles follow in the mesh
  std::size_t scanned = 0;
  dvec3 up{0, 0, 1};                 // unit vector from the border to the surface
  std::vector<std::string> repairs;  // repairs of the mesh, as texts for the user
};

/// Reads an intraoral scan, which may be open. Loose pieces are removed, holes are closed, and a base is added under
/// the longest border. Only the option mesh_unit is used.
ArchSurface read_arch(const std::filesystem::path& file, const ImportOptions& options);

}  // namespace typodont::haptics::importing
