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
  Mesh mesh;                // closed; the triangles face outward
  std::size_t scanned = 0;  // number of the scan's triangles, including those that close holes; the base's triangles
                            // follow them in the mesh
  dvec3 up{0, 0, 1};        // unit, from the border to the surface
  std::vector<std::string> repairs;  // what was repaired, in plain words
};

/// Reads an intraoral scan, which may be open. Loose pieces are removed, holes are closed, and a base is added under
/// the longest border. Only the option mesh_unit is used.
ArchSurface read_arch(const std::filesystem::path& file, const ImportOptions& options);

}  // namespace typodont::haptics::importing
