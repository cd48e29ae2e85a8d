// A level set of OpenVDB with OpenVDB's own functions, as a program would use them: baselines for benchmarks.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/dense_tissue.h"

namespace typodont::bench {

class LevelSet {
 public:
  /// `band`: voxels, distance from the surface up to which distances are stored. OpenVDB's own level sets use 3.
  LevelSet(const haptics::DenseTissue& tissue, float band);
  /// A ball; radius and centre in voxels.
  LevelSet(double radius, const dvec3& center, float band);
  ~LevelSet();

  /// Removes a ball with csgDifference; `radius`: m.
  void cut_ball(const dvec3& center_W, double radius);
  /// Returns the volume, m³, computed as in TissueVolume::volumes().
  double volume() const;

  /// Penalty contact: returns the position (m) to which the gradient of the field pushes a ball's centre, so that the
  /// ball of `radius` (m) only touches the surface.
  dvec3 push(const dvec3& center_W, double radius) const;

  struct Mesh {
    std::vector<glm::vec3> points;  // voxels
    std::vector<std::array<std::uint32_t, 3>> triangles;
  };
  /// Extracts the mesh with volumeToMesh on one thread. Returns the median time in ns.
  double extract(int repeats, Mesh& mesh) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::bench
