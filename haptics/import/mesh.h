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
  std::vector<std::array<int, 3>> corners;  // indices of each triangle's points
  std::vector<Color> colors;                // colour of each point; empty if the file has no colours
};

/// Repairs that were made between file and surface.
struct MeshRepairs {
  std::size_t collapsed = 0;      // triangles with two equal corners, removed
  std::size_t welded = 0;         // corners merged with another corner at almost the same position
  std::size_t copies = 0;         // second copies of triangles, removed
  std::size_t turned = 0;         // triangles reversed to agree with their neighbours
  std::size_t shells_turned = 0;  // whole shells that were inside out, reversed
  std::size_t holes = 0;          // small holes that were closed
  std::size_t hole_edges = 0;     // total number of edges of these holes

  std::vector<std::string> in_words() const;
};

/// Tolerance for equal points: kWeldShare times the mesh's diagonal, but at most kWeldMost.
inline constexpr double kWeldShare = 1e-5, kWeldMost = 1e-6;  // fraction; m

/// Reads a surface, which may be open. `unit`: m per unit of the file. Corners at equal or almost equal positions
/// become one point. Counts collapsed triangles and welded corners in `repairs`.
Mesh read_surface(const std::filesystem::path& file, double unit, MeshRepairs& repairs);

/// Reads a closed and oriented surface: second copies of triangles are removed, triangles are reversed to agree with
/// their neighbours, small holes are closed; shells face outward, and shells within another shell face inward. Throws
/// Error if the surface is still open.
Mesh read_mesh(const std::filesystem::path& file, double unit, MeshRepairs& repairs);

}  // namespace typodont::haptics::importing
