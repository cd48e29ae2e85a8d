// Analytic solids with exact distances: tissue for tests, teaching and benchmarks.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/json.h"
#include "haptics/dense_tissue.h"

namespace typodont::haptics {

/// A closed shape with its signed distance, negative inside. For intersections and differences the distance may be less
/// than the true one, but never more. Metres, frame W.
class Solid {
 public:
  virtual ~Solid() = default;
  virtual double distance(const dvec3& p_W) const = 0;
  /// Bounds; infinite for unbounded solids.
  virtual void bounds(dvec3& lo, dvec3& hi) const = 0;
};

/// Finds and reads the mesh files that JSON text names. haptics itself reads no mesh formats; `read_mesh_solid` of
/// Typodont::import does.
struct SolidFiles {
  /// Finds the path of a named file. Empty: files are searched beside the JSON file.
  std::function<std::filesystem::path(const std::string& name)> find;
  /// Makes a solid from a mesh file; `unit`: m per unit of the file. Throws Error. Empty: a mesh is an error.
  std::function<std::unique_ptr<Solid>(const std::filesystem::path& file, double unit)> read_mesh;
};

/// Reads one of: sphere, halfspace, box, cylinder, cone, capsule, torus, mesh, union, intersection, difference. Throws
/// Error.
std::unique_ptr<Solid> read_solid(const Json& json, const SolidFiles& files = {});

/// All points nearer than `radius` to the segment from a to b; a and b may be equal.
std::unique_ptr<Solid> capsule(const dvec3& a_W, const dvec3& b_W, double radius);

/// Reads the key "hardness" of an object, a fraction 0..1 of the tissue's own hardness, as a byte (hardness.h);
/// kOwnHardness if there is no such key. Throws Error.
std::uint8_t read_hardness(const Json& json);

/// Reads the "tissue" object of a scene with "solids" and samples it on voxels. Where solids overlap, the later one
/// determines label and hardness. Throws Error, also if the volume is too large.
DenseTissue read_solids(const Json& json, const SolidFiles& files = {});

/// Names of the mesh files in a solid or a "tissue" object, as written there.
std::vector<std::string> mesh_files(const Json& json);

}  // namespace typodont::haptics
