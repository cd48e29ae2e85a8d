// Triangles of a level set, extracted by OpenVDB's volumeToMesh on one thread. Used only as a reference in benchmarks.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

namespace typodont::haptics {

class MeshBaseline {
 public:
  // voxels, distance from the surface up to which distances are stored; OpenVDB's own level sets use at least 3
  static constexpr double kBand = 4;

  /// Creates an empty level set, in which every sample is far outside.
  MeshBaseline();
  ~MeshBaseline();
  MeshBaseline(const MeshBaseline&) = delete;
  MeshBaseline& operator=(const MeshBaseline&) = delete;

  /// Sets one sample in the narrow band around the surface. `distance`: voxels, negative inside.
  void set(const glm::ivec3& i, float distance);
  /// Must be called after the last sample. Sets the signs of the samples outside the narrow band around the surface.
  void finish();

  struct Mesh {
    std::vector<glm::vec3> points;  // voxels, positions of the vertices
    std::vector<std::array<std::uint32_t, 3>> triangles;
  };
  /// Extracts the mesh `repeats` times. Returns the median time in ns; `mesh` receives the result.
  double extract(int repeats, Mesh& mesh) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::haptics
