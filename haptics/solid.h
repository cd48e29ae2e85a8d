// Analytic solids with exact distances. They provide tissue for tests, teaching and benchmarks.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/json.h"
#include "haptics/dense_tissue.h"

namespace typodont::haptics {

/// A closed shape with its signed distance, negative inside. For an intersection or difference, the distance may be
/// smaller than the true distance, but never larger. Metres, workbench frame W.
class Solid {
 public:
  virtual ~Solid() = default;
  virtual double distance(const dvec3& p_W) const = 0;
  /// Computes the distances of the points `p_W`, with the same bits as distance(). Faster than single calls for a mesh,
  /// if each point is near the previous one.
  virtual void distances(std::span<const dvec3> p_W, std::span<double> distances) const {
    for (std::size_t i = 0; i < p_W.size(); ++i) distances[i] = distance(p_W[i]);
  }
  /// Returns the corners of the bounding box; infinite for an unbounded solid.
  virtual void bounds(dvec3& lo, dvec3& hi) const = 0;
};

/// Lists the voxels of a block in an order in which successive voxels are neighbours, as Solid::distances() needs them.
/// `first`: corner of the block; `end`: the corner opposite to it, not included.
void voxels_of_block(const glm::ivec3& first, const glm::ivec3& end, std::vector<glm::ivec3>& voxels);

/// Functions that find and read the mesh files named in a JSON text. haptics reads no mesh formats itself;
/// `read_mesh_solid` in Typodont::import does.
struct SolidFiles {
  /// Returns the path of a named file. If this function is empty, the file is in the folder of the JSON file.
  std::function<std::filesystem::path(const std::string& name)> find;
  /// Creates a solid from a mesh file. `unit`: metres per unit of the file. Throws Error. If this function is empty, a
  /// mesh in the JSON text is an error.
  std::function<std::unique_ptr<Solid>(const std::filesystem::path& file, double unit)> read_mesh;
};

/// Reads a solid of one of the kinds sphere, halfspace, box, cylinder, cone, capsule, torus, mesh, union, intersection,
/// difference. Throws Error.
std::unique_ptr<Solid> read_solid(const Json& json, const SolidFiles& files = {});

/// Returns a capsule: all points nearer than `radius` to the segment from a to b, which may be equal.
std::unique_ptr<Solid> capsule(const dvec3& a_W, const dvec3& b_W, double radius);

/// Reads the key "hardness" of a JSON object. Its value 0..1 is a fraction of the tissue's own hardness; the result is
/// a byte (hardness.h). Without the key, returns kOwnHardness. Throws Error.
std::uint8_t read_hardness(const Json& json);

/// Reads the "tissue" object of a scene that contains "solids", and samples the solids on a grid of voxels. Where
/// solids overlap, the later one determines label and hardness. Throws Error, for example if the volume is too large.
DenseTissue read_solids(const Json& json, const SolidFiles& files = {});

/// Returns the names of all mesh files in a solid or a "tissue" object, as written there.
std::vector<std::string> mesh_files(const Json& json);

}  // namespace typodont::haptics
