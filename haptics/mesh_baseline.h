// Triangles of a level set by OpenVDB's volumeToMesh, on one thread. Only a reference for bench rows.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

namespace typodont::haptics {

class MeshBaseline {
 public:
  static constexpr double kBand = 4;  // voxels; OpenVDB's own level sets have a half width of at least 3

  /// The empty level set: every sample is far outside.
  MeshBaseline();
  ~MeshBaseline();
  MeshBaseline(const MeshBaseline&) = delete;
  MeshBaseline& operator=(const MeshBaseline&) = delete;

  /// Sets a sample within the band. `distance`: voxels, negative inside.
  void set(const glm::ivec3& i, float distance);
  /// Call after the last sample: sets the signs of the samples outside the band.
  void finish();

  struct Mesh {
    std::vector<glm::vec3> points;  // voxels
    std::vector<std::array<std::uint32_t, 3>> triangles;
  };
  /// Extracts the mesh `repeats` times. Returns the median time, ns, and the last mesh.
  double extract(int repeats, Mesh& mesh) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::haptics
