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

/// Solid with a signed distance (m, frame W), negative inside. For intersections and differences, a lower bound of the
/// true distance.
class Solid {
 public:
  virtual ~Solid() = default;
  virtual double distance(const dvec3& p_W) const = 0;
  /// Computes distance() for several points; the results are bit-identical. Faster for meshes if consecutive points are
  /// close to each other.
  virtual void distances(std::span<const dvec3> p_W, std::span<double> distances) const {
    for (std::size_t i = 0; i < p_W.size(); ++i) distances[i] = distance(p_W[i]);
  }
  /// Corners of the bounding box, m, frame W; infinite for an unbounded solid.
  virtual void bounds(dvec3& lo, dvec3& hi) const = 0;
};

/// Lists the voxels from `first` to `end` (exclusive) so that consecutive ones are neighbours, for Solid::distances().
void voxels_of_block(const glm::ivec3& first, const glm::ivec3& end, std::vector<glm::ivec3>& voxels);

/// Finds and reads mesh files of a JSON solid. This module can't read them; `read_mesh_solid` of Typodont::import can.
struct SolidFiles {
  /// Finds a file by its name. If there is no such function, files are in the folder of the JSON file.
  std::function<std::filesystem::path(const Json& name)> find;
  /// Reads a mesh. `unit`: metres per unit of the file. Throws Error. No function: a mesh in the JSON is an error.
  std::function<std::unique_ptr<Solid>(const std::filesystem::path& file, double unit)> read_mesh;
};

/// For checks of a scene. Mesh files are not searched for or read, and a mesh becomes a null pointer.
SolidFiles unread_meshes();

/// Reads a solid. Throws Error.
std::unique_ptr<Solid> read_solid(const Json& json, const SolidFiles& files = {});
std::vector<std::unique_ptr<Solid>> read_solid_list(const std::vector<Json>& list, const SolidFiles& files = {});

/// Lists the keys of a solid, for the definition "solid" of the form kSolid.
void list_solid(Keys& keys);

/// All points within `radius` of the segment a–b; a may equal b.
std::unique_ptr<Solid> capsule(const dvec3& a_W, const dvec3& b_W, double radius);

/// Reads the name of a tissue. Throws Error that states `expected`, also for "air".
Tissue read_tissue_name(const Json& json, std::string_view expected = "the name of a tissue");
/// Reads two corners, in millimetres. Throws Error.
void read_box(const Json& json, dvec3& lo, dvec3& hi);

/// A solid with label, hardness and colour of its voxels.
struct LabelledSolid {
  Tissue tissue = Tissue::kEnamel;
  std::uint8_t hardness = kOwnHardness;
  VoxelColor color = kTissueColor;
  std::unique_ptr<Solid> solid;
};
/// Declares the keys of an entry of "solids" or "paint". Throws Error.
void describe_labelled_solid(Keys& keys, LabelledSolid& labelled, const SolidFiles& files);

/// Declares the keys of a tissue with "solids"; checks a tissue without its mesh files. Throws Error.
void describe_solid_tissue(Keys& keys);
/// Reads a tissue with "solids", and samples it on voxels; a later solid overrides label, hardness and colour of
/// earlier ones. Throws Error, for example if it is too large.
DenseTissue read_solids(const Json& json, const SolidFiles& files = {});

/// Returns the names of mesh files as the JSON of a solid or tissue states them.
std::vector<Json> mesh_files(const Json& json);

}  // namespace typodont::haptics
