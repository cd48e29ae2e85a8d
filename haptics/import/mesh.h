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

struct Mesh {
  std::vector<glm::dvec3> points;           // m, positions of the mesh's points
  std::vector<std::array<int, 3>> corners;  // indices of each triangle's points
  std::vector<Color> colors;                // per point; may be empty
};

/// While reading.
struct MeshRepairs {
  std::size_t collapsed = 0;  // number of removed triangles with two equal corners
  std::size_t welded = 0;     // merged corners
  std::size_t copies = 0;     // removed copies
  std::size_t turned = 0;     // triangles reversed to agree
  // shells that were inside out
  std::size_t shells_turned = 0;
  std::size_t holes = 0;       // number of small holes that were closed
  std::size_t hole_edges = 0;  // total number of edges of the closed holes
  // m, of all repairs
  std::vector<glm::dvec3> places;

  std::vector<std::string> in_words() const;
};

/// of the diagonal, and m: closer points are equal
inline constexpr double kWeldShare = 1e-5, kWeldMost = 1e-6;

/// Reads a surface, which may be open. `unit` is the length in m of one unit of the file. Corners at equal or almost
/// equal positions become one point. Counts removed triangles and merged corners in `repairs`.
Mesh read_surface(const std::filesystem::path& file, double unit, MeshRepairs& repairs);

/// Reads a surface and makes it closed and oriented. Second copies of triangles are removed. Triangles are reversed if
/// they do not agree with their neighbours. Small holes are closed. Outer shells face outward, and the shells of
/// hollows face inward. Throws Error if the surface is still open.
Mesh read_mesh(const std::filesystem::path& file, double unit, MeshRepairs& repairs);

}  // namespace typodont::haptics::importing
