// Solids with exact distances: tissue for tests, teaching and benchmarks.
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

/// Signed distance, negative inside; of intersections and differences never too large. m, W.
class Solid {
 public:
  virtual ~Solid() = default;
  virtual double distance(const dvec3& p_W) const = 0;
  /// The bits of distance(). Faster for a mesh if each point is near the previous one.
  virtual void distances(std::span<const dvec3> p_W, std::span<double> distances) const {
    for (std::size_t i = 0; i < p_W.size(); ++i) distances[i] = distance(p_W[i]);
  }
  /// Infinite if unbounded.
  virtual void bounds(dvec3& lo, dvec3& hi) const = 0;
};

/// Neighbours in succession, for Solid::distances(). From `first` up to, without, `end`.
void voxels_of_block(const glm::ivec3& first, const glm::ivec3& end, std::vector<glm::ivec3>& voxels);

/// For mesh files in JSON: haptics reads none, `read_mesh_solid` of Typodont::import does.
struct SolidFiles {
  /// Empty: in the JSON file's folder.
  std::function<std::filesystem::path(const Json& name)> find;
  /// `unit`: metres per unit. Throws Error. Empty: a mesh in JSON is an error.
  std::function<std::unique_ptr<Solid>(const std::filesystem::path& file, double unit)> read_mesh;
};

/// Sphere, halfspace, box, cylinder, cone, capsule, torus, mesh, union, intersection, difference. Throws Error.
std::unique_ptr<Solid> read_solid(const Json& json, const SolidFiles& files = {});

/// Within `radius` of a–b, which may be equal.
std::unique_ptr<Solid> capsule(const dvec3& a_W, const dvec3& b_W, double radius);

/// "hardness" 0..1 of the tissue's own, as byte (dense_tissue.h); kOwnHardness without. Throws Error.
std::uint8_t read_hardness(const Json& json);

/// "tissue" with "solids", sampled on voxels; later solids decide label and hardness. Throws Error, for example if too
/// large.
DenseTissue read_solids(const Json& json, const SolidFiles& files = {});

/// As written in a solid or "tissue".
std::vector<Json> mesh_files(const Json& json);

}  // namespace typodont::haptics
