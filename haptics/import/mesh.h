// Triangle meshes from STL, PLY, OBJ and glTF files. Set-up time; throws Error.
#pragma once

#include <array>
#include <filesystem>
#include <glm/glm.hpp>
#include <vector>

namespace typodont::haptics::importing {

struct Mesh {
  std::vector<glm::dvec3> points;           // m
  std::vector<std::array<int, 3>> corners;  // of each triangle
};

/// `unit`: metres per unit of the file. Corners at the same place are one point. The surface may be open. `collapsed`:
/// how many triangles with two equal corners were left out.
Mesh read_surface(const std::filesystem::path& file, double unit, std::size_t& collapsed);
/// The same; a surface that is not closed is an error.
Mesh read_mesh(const std::filesystem::path& file, double unit);

}  // namespace typodont::haptics::importing
