// Triangle meshes from STL, PLY, OBJ and glTF files. Set-up time; throws Error.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace typodont::haptics::importing {

using Color = std::array<std::uint8_t, 3>;  // sRGB

struct Mesh {
  std::vector<glm::dvec3> points;           // m
  std::vector<std::array<int, 3>> corners;  // of each triangle
  std::vector<Color> colors;                // of each point; empty where the file has none
};

/// What was mended on the way from a file to a surface.
struct MeshRepairs {
  std::size_t collapsed = 0;      // triangles with two equal corners, left out
  std::size_t welded = 0;         // corners moved onto another one that lay a hair's breadth away
  std::size_t copies = 0;         // second copies of triangles, left out
  std::size_t turned = 0;         // triangles turned to agree with their neighbours
  std::size_t shells_turned = 0;  // whole shells turned inside out
  std::size_t holes = 0;          // small holes closed, …
  std::size_t hole_edges = 0;     // … with so many edges in all

  std::vector<std::string> in_words() const;
};

/// Corners within this share of the mesh's diagonal, at most kWeldMost, are one point.
inline constexpr double kWeldShare = 1e-5, kWeldMost = 1e-6;  // …, m

/// `unit`: metres per unit of the file. Corners at the same place, and nearly the same place, are one point. The
/// surface may be open. Counts into `repairs` what was collapsed and welded.
Mesh read_surface(const std::filesystem::path& file, double unit, MeshRepairs& repairs);

/// The same, closed and oriented: copies go, triangles are turned to agree with their neighbours, small holes are
/// closed, shells are turned outwards, those within another one inwards. A surface that is open after that is an error.
Mesh read_mesh(const std::filesystem::path& file, double unit, MeshRepairs& repairs);

}  // namespace typodont::haptics::importing
