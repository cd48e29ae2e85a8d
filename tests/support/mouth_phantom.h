// Intraoral scans of one mouth: the synthetic jaw (fuse_phantom.h), its mirror image as the opposing jaw, and the bite.
#pragma once

#include <random>

#include "tests/support/fuse_phantom.h"

namespace typodont::test {

inline constexpr double kGap = 0.1e-3;  // m, distance between the highest points of the two jaws

/// Returns the mirror image of the lower jaw above it.
inline TissueMesh upper_jaw() {
  TissueMesh mesh = true_surface();
  for (dvec3& p : mesh.vertices) p.z = 2 * JawPhantom::kTop * kMillimetre + kGap - p.z;
  for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  return mesh;
}

inline TissueMesh moved(TissueMesh mesh, const Pose& X) {
  for (dvec3& p : mesh.vertices) p = X * p;
  return mesh;
}

/// Returns the side of both jaws that a scanner sees from the direction −y, with noise of 0.02 mm.
inline TissueMesh bite_scan() {
  TissueMesh both = true_surface();
  const TissueMesh upper = upper_jaw();
  const auto first = static_cast<unsigned>(both.vertices.size());
  both.vertices.insert(both.vertices.end(), upper.vertices.begin(), upper.vertices.end());
  for (const glm::uvec3& t : upper.triangles) both.triangles.push_back(t + first);
  std::erase_if(both.triangles, [&](const glm::uvec3& t) {
    const dvec3 a = both.vertices[t.x];
    const dvec3 n = glm::cross(both.vertices[t.y] - a, both.vertices[t.z] - a);
    return n.y > -0.3 * glm::length(n);
  });
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0, 0.02e-3);
  for (dvec3& p : both.vertices) p.y += noise(random);
  return both;
}

}  // namespace typodont::test
