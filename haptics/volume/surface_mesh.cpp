// The surface mesh of OpenVDB, with vertices moved onto the zero set of the field.
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/VolumeToMesh.h>

#include "haptics/tissue_mesh.h"
#include "haptics/volume/tissue_grids.h"

namespace typodont::haptics {

namespace {

constexpr double kBelow = 0.5;     // voxels, depth below a triangle at which the triangle's tissue is read
constexpr int kSteps = 3;          // number of Newton steps per vertex
constexpr double kMaxStep = 0.25;  // voxels, largest length of a Newton step

/// Moves a vertex onto the surface by Newton steps along the gradient. OpenVDB uses means of edge crossings, which are
/// not on a curved surface.
template <class Accessor>
openvdb::Vec3d onto_surface(const Accessor& field, openvdb::Vec3d p) {
  using openvdb::tools::BoxSampler;
  const auto value = [&](const openvdb::Vec3d& q) { return static_cast<double>(BoxSampler::sample(field, q)); };
  constexpr double kDifference = 0.25;  // voxels, step of the central differences for the gradient
  for (int i = 0; i < kSteps; ++i) {
    openvdb::Vec3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
      openvdb::Vec3d off(0.0);
      off[axis] = kDifference;
      gradient[axis] = (value(p + off) - value(p - off)) / (2 * kDifference);
    }
    const double square = gradient.lengthSqr();
    // Near the surface, |gradient|² is about 1. If it is 0.04 or less, the vertex does not move.
    if (!(square > 0.04)) return p;
    openvdb::Vec3d step = -value(p) / square * gradient;
    if (const double length = step.length(); length > kMaxStep) step *= kMaxStep / length;
    p += step;
  }
  return p;
}

}  // namespace

TissueMesh surface_mesh(const TissueVolume& volume) {
  if (volume.mesh()) return *volume.mesh();
  return volume.extract_mesh();
}

TissueMesh TissueVolume::extract_mesh() const {
  const Impl& v = *impl_;
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(*v.distance, points, triangles, quads, 0.0, 0.0);
  TissueMesh mesh;
  mesh.vertices.reserve(points.size());
  std::vector<openvdb::Vec3d> place(points.size());  // voxels, positions on the zero set
  const auto field = v.distance->getConstAccessor();
  for (std::size_t i = 0; i < points.size(); ++i) {
    place[i] = onto_surface(field, openvdb::Vec3d(points[i]));
    mesh.vertices.push_back(v.frame.to_world({place[i].x(), place[i].y(), place[i].z()}));
  }
  const auto labels = v.tissue->getConstAccessor();
  const auto label_at = [&](const openvdb::Vec3d& p) { return shown_in(labels.getValue(openvdb::Coord::round(p))); };
  const auto add = [&](unsigned a, unsigned b, unsigned c) {
    const openvdb::Vec3d normal = (place[b] - place[a]).cross(place[c] - place[a]);
    const double size = normal.length();
    const openvdb::Vec3d center = (place[a] + place[b] + place[c]) / 3.0;
    const openvdb::Vec3d down = size > 0 ? -kBelow / size * normal : openvdb::Vec3d(0.0);
    Tissue tissue = label_at(center + down);
    if (tissue == Tissue::kAir) tissue = label_at(center);
    mesh.triangles.emplace_back(a, b, c);
    mesh.tissue.push_back(tissue);
  };
  for (const auto& t : triangles) add(t[0], t[1], t[2]);
  for (const auto& q : quads) add(q[0], q[1], q[2]), add(q[0], q[2], q[3]);
  return mesh;
}

}  // namespace typodont::haptics
