// Reads triangle meshes from STL, PLY, OBJ and glTF files. Not for real-time threads; throws Error.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace typodont::haptics::importing {

using Color = std::array<std::uint8_t, 3>;  // sRGB

struct Triangle {
  glm::dvec3 a, b, c;
  glm::dvec3 area_vector() const { return 0.5 * glm::cross(b - a, c - a); }  // area × normal
};

struct Mesh {
  std::vector<glm::dvec3> points;           // m, positions of the mesh's points
  std::vector<std::array<int, 3>> corners;  // indices of each triangle's points
  std::vector<Color> colors;                // one per point; may be empty

  const glm::dvec3& point(int i) const { return points[static_cast<std::size_t>(i)]; }
  Triangle triangle(std::size_t t) const { return {point(corners[t][0]), point(corners[t][1]), point(corners[t][2])}; }
};

/// Repairs made while a mesh was read.
struct MeshRepairs {
  std::size_t collapsed = 0;  // number of removed triangles with two equal corners
  std::size_t welded = 0;     // number of corners that were merged with another corner
  std::size_t copies = 0;     // number of removed copies of triangles
  std::size_t turned = 0;     // number of triangles reversed to agree with their neighbours
  // Number of shells (connected surfaces) that were inside out, and were reversed.
  std::size_t shells_turned = 0;
  std::size_t holes = 0;       // number of small holes that were closed
  std::size_t hole_edges = 0;  // total number of edges of the closed holes
  // Positions of all repairs, m.
  std::vector<glm::dvec3> places;

  std::vector<std::string> in_words() const;
};

/// Points become one point if they are closer than kWeldShare × the mesh's diagonal and closer than kWeldMost (m).
inline constexpr double kWeldShare = 1e-5, kWeldMost = 1e-6;

/// Reads a surface, which may be open. `unit`: length of a unit of the file, m. Corners at almost equal positions
/// become one point. Counts removed triangles and merged corners in `repairs`.
Mesh read_surface(const std::filesystem::path& file, double unit, MeshRepairs& repairs);

/// Reads a surface and makes it closed and oriented: removes copies of triangles, reverses inconsistent ones, closes
/// small holes. Shells of hollows face inward. Throws Error if the surface is still open.
Mesh read_mesh(const std::filesystem::path& file, double unit, MeshRepairs& repairs);

}  // namespace typodont::haptics::importing
