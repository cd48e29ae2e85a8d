// An intraoral scan of the synthetic jaw (jaw_phantom.h), and the jaw's CT as `import --preset jaw` reads it. The scan
// is the true surface of the crowns and of the gum around them, with noise, in a frame of its own.
#pragma once

#include <random>

#include "engine/base/pose.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/import/import.h"
#include "haptics/tissue_mesh.h"
#include "haptics/tissue_volume.h"
#include "tests/support/jaw_phantom.h"

namespace typodont::test {

using haptics::DenseTissue;
using haptics::TissueMesh;

inline constexpr double kGum = JawPhantom::kNeck + 1;  // mm, height of the gum around the crowns

inline const JawPhantom& jaw() {
  static const JawPhantom jaw = [] {
    JawArtefacts artefacts;
    artefacts.fissure = 0.8;
    return JawPhantom(artefacts);
  }();
  return jaw;
}
inline const DenseTissue& ct() {
  static const DenseTissue tissue = [] {
    haptics::ImportOptions options;
    options.preset = haptics::ImportPreset::kJaw;
    options.greys = false;
    const auto file = write_nrrd("fuse_jaw.nrrd", jaw().phantom(), bytes_as<float>(jaw().scan()), "float");
    return import_tissue(file, options).tissue;
  }();
  return tissue;
}

/// Returns the signed distance (mm) to the true surface of crowns and gum along the steepest direction. Small distances
/// are exact.
inline double true_distance(const dvec3& q) {
  double d = q.z - kGum;
  for (std::size_t k = 0; k < JawPhantom::kTeeth.size(); ++k) {
    const dvec3 r = q - dvec3(JawPhantom::kTeeth[k], JawPhantom::kY, 0);
    d = std::min(d, jaw().crown_distance(k, r));
  }
  return d;
}

/// Returns the true surface of crowns and gum as triangles in frame C (m). It is open below.
inline const TissueMesh& true_surface() {
  static const TissueMesh mesh = [] {
    constexpr double kStep = 0.12;  // mm
    DenseTissue t;
    t.frame = {dvec3(4, 6, kGum - 1.2) * kMillimetre, kStep * kMillimetre};
    t.size = glm::ivec3(dvec3(21.5, 12, 9) / kStep);
    t.band = 1e-3;
    for_each_voxel(t.size, [&](int x, int y, int z) {
      const dvec3 q = t.frame.to_world(dvec3(x, y, z)) / kMillimetre;
      t.distance.push_back(static_cast<float>(std::clamp(true_distance(q), -1.0, 1.0) * kMillimetre));
      t.tissue.push_back(Tissue::kEnamel);
    });
    TissueMesh surface = haptics::TissueVolume(t).extract_mesh();
    // The border of the box closes the surface. These triangles are removed, because a scanner does not see them.
    std::erase_if(surface.triangles, [&](const glm::uvec3& c) {
      for (int k = 0; k < 3; ++k) {
        const dvec3 q = surface.vertices[c[k]] / kMillimetre;
        if (q.z < kGum - 0.3 || q.x < 4.5 || q.x > 25 || q.y < 6.5 || q.y > 17.5) return true;
      }
      return false;
    });
    return surface;
  }();
  return mesh;
}

/// Returns the true surface in the scanner's frame, with noise of 0.02 mm along the normals.
inline TissueMesh scanned(const Pose& X_CS, unsigned seed) {
  TissueMesh mesh = true_surface();
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 0.02e-3);
  std::vector<dvec3> normals(mesh.vertices.size(), dvec3(0));
  for (const glm::uvec3& t : mesh.triangles) {
    const dvec3 n = glm::cross(mesh.vertices[t.y] - mesh.vertices[t.x], mesh.vertices[t.z] - mesh.vertices[t.x]);
    for (int k = 0; k < 3; ++k) normals[t[k]] += n;
  }
  const Pose X_SC = inverse(X_CS);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (normals[i] != dvec3(0)) mesh.vertices[i] += noise(random) * glm::normalize(normals[i]);
    mesh.vertices[i] = X_SC * mesh.vertices[i];
  }
  return mesh;
}

inline Pose random_pose(std::mt19937& random, double turn, double shift) {
  std::normal_distribution<double> normal(0, 1);
  const dvec3 axis = glm::normalize(dvec3(normal(random), normal(random), normal(random)));
  return {shift * dvec3(normal(random), normal(random), normal(random)), glm::angleAxis(turn, axis)};
}

/// Returns the pose X_CS with a random error, as points clicked with an error of 1 mm would give it.
inline Pose clicked(const Pose& X_CS, std::mt19937& random) {
  const Pose error = random_pose(random, 4 * kDegree, 0.6e-3);
  const dvec3 middle = dvec3(14.75, JawPhantom::kY, 27) * kMillimetre;
  return Pose{middle + error.p - error.R * middle, error.R} * X_CS;
}

}  // namespace typodont::test
