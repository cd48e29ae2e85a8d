// Analytic solids: tissue for tests, teaching and benchmarks, with exact distances.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/json.h"
#include "haptics/dense_tissue.h"

namespace typodont::haptics {

/// A closed shape with its signed distance, negative inside; where shapes were intersected or taken away it may be less
/// than the true one, never more. Metres, frame W.
class Solid {
 public:
  virtual ~Solid() = default;
  virtual double distance(const dvec3& p_W) const = 0;
  /// Bounds; infinite for unbounded solids.
  virtual void bounds(dvec3& lo, dvec3& hi) const = 0;
};

/// What a solid needs that its JSON text does not hold: the mesh files that it names. haptics itself reads no mesh
/// formats: `read_mesh_solid` of Typodont::import does.
struct SolidFiles {
  /// Where a named file lies. Without it a file is looked for beside the JSON file.
  std::function<std::filesystem::path(const std::string& name)> find;
  /// Makes a solid of a mesh file; `unit` in m per unit of the file. Throws Error. Without it a mesh is an error.
  std::function<std::unique_ptr<Solid>(const std::filesystem::path& file, double unit)> read_mesh;
};

/// Reads one of: sphere, halfspace, box, cylinder, cone, capsule, torus, mesh, union, intersection, difference. Throws
/// Error.
std::unique_ptr<Solid> read_solid(const Json& json, const SolidFiles& files = {});

/// All nearer than `radius` to the line from a to b, which may be a point.
std::unique_ptr<Solid> capsule(const dvec3& a_W, const dvec3& b_W, double radius);

/// The key "hardness" of an object, 0..1 of the tissue's own hardness, as a byte (hardness.h); kOwnHardness where it is
/// not given. Throws Error.
std::uint8_t read_hardness(const Json& json);

/// The "tissue" object of a scene with "solids": samples them on voxels. Later solids overwrite label and hardness of
/// earlier ones where they overlap. Throws Error, also when the volume would not fit into memory.
DenseTissue read_solids(const Json& json, const SolidFiles& files = {});

/// Names of the mesh files in a solid or a "tissue" object, as they stand there.
std::vector<std::string> mesh_files(const Json& json);

}  // namespace typodont::haptics
