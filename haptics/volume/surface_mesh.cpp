// The zero set of the field as a mesh with a tissue for each triangle.
#include "haptics/tissue_mesh.h"
#include "haptics/volume/tissue_grids.h"
#include "haptics/volume/vdb_guard.h"

namespace typodont::haptics {

TissueMesh surface_mesh(const TissueVolume& volume) {
  if (volume.mesh()) return *volume.mesh();
  return volume.extract_mesh();
}

TissueMesh TissueVolume::extract_mesh() const {
  const Impl& v = *impl_;
  FlatMesh surface = surface_of(v.distance);
  TissueMesh mesh;
  mesh.vertices.reserve(surface.vertices.size());
  for (const dvec3& p_V : surface.vertices) mesh.vertices.push_back(v.frame.to_world(p_V));
  LabelGrid::Reader labels(v.tissue);
  const auto label_at = [&](const dvec3& p_V) { return shown_in(labels.value(glm::ivec3(glm::floor(p_V + 0.5)))); };
  constexpr double kBelow = 0.5;  // voxels, depth below a triangle at which the triangle's tissue is read
  for (const glm::uvec3& t : surface.triangles) {
    const dvec3 &a = surface.vertices[t.x], &b = surface.vertices[t.y], &c = surface.vertices[t.z];
    const dvec3 normal = glm::cross(b - a, c - a), center = (a + b + c) / 3.0;
    const double size = glm::length(normal);
    const Tissue below = label_at(size > 0 ? center - kBelow / size * normal : center);
    mesh.tissue.push_back(below == Tissue::kAir ? label_at(center) : below);
  }
  mesh.triangles = std::move(surface.triangles);
  return mesh;
}

}  // namespace typodont::haptics
