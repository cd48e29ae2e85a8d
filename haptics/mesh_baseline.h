// Triangles as OpenVDB makes them of a level set (volumeToMesh), on one thread. Only a yardstick for bench rows.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

namespace typodont::haptics {

class MeshBaseline {
 public:
  static constexpr double kBand = 4;  // voxels: OpenVDB's own level sets are no narrower than 3

  /// Far outside everywhere.
  MeshBaseline();
  ~MeshBaseline();
  MeshBaseline(const MeshBaseline&) = delete;
  MeshBaseline& operator=(const MeshBaseline&) = delete;

  /// A sample within the band, voxels, negative inside.
  void set(const glm::ivec3& i, float distance);
  /// After the last sample: what lies within the band gets its sign.
  void finish();

  struct Mesh {
    std::vector<glm::vec3> points;  // voxels
    std::vector<std::array<std::uint32_t, 3>> triangles;
  };
  /// Median of so many extractions, ns; the mesh of the last.
  double extract(int repeats, Mesh& mesh) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::haptics
