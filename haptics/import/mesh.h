// Closed triangle meshes from STL, PLY and OBJ files. Set-up time; throws Error.
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

/// `unit`: metres per unit of the file. Corners at the same place are one point; a surface that is not closed is an
/// error.
Mesh read_mesh(const std::filesystem::path& file, double unit);

}  // namespace typodont::haptics::importing
