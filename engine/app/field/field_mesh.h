// Makes triangle meshes of bodies that are described by functions of a position in frame W. Uses the mesher of the
// tissue. Used for bodies that are only drawn, for example neighbouring teeth.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "engine/app/field/brick_update.h"
#include "engine/surface/surface_mesher.h"

namespace typodont {

/// Replaces the normal of each vertex by the gradient of the distance function. Reason: the mesher treats each bend
/// between two large triangles as a crease (a sharp edge), so a coarse mesh would look faceted. At a real crease, the
/// mesher's normal is kept. `lo`: m, frame W, origin of the vertices. `step`: m; each component of the gradient is the
/// difference of the distances at +step and -step from the vertex.
template <class Distance>
void shade_by_slope(std::vector<render::MeshUpdate>& bricks, const dvec3& lo, double step, Distance&& distance) {
  /// The vertex lies at a crease if the cosine of the angle between two directions is smaller than this. The directions
  /// are the normal that the mesher computed, and the gradient of the distance function.
  constexpr float kSameSide = 0.5f;
  for (render::MeshUpdate& brick : bricks) {
    for (render::Vertex& v : brick.vertices) {
      const dvec3 p = lo + dvec3(v.p);
      dvec3 slope;
      for (int axis = 0; axis < 3; ++axis) {
        dvec3 along(0);
        along[axis] = step;
        slope[axis] = distance(p + along) - distance(p - along);
      }
      const double length = glm::length(slope);
      if (!(length > 0)) continue;
      const glm::vec3 n(slope / length);
      if (glm::dot(n, v.n) > kSameSide) v.n = n;
    }
  }
}

constexpr double kSteepest = 1.5;  // m per m, largest allowed slope of the distance function of a body that is meshed

/// Meshes the box from `lo` to `hi` (m, frame W). Vertices are relative to `lo`. `distance(p)`: m, negative inside,
/// with a slope of at most kSteepest. `label(p)`: the tissue at p, called only near the surface. `tolerances`: voxels,
/// largest error of each mesh; one mesh is made for each tolerance. `wanted(lo, hi)`: false for a box that is not
/// meshed.
template <std::size_t kMeshes, class Distance, class Label, class Wanted>
std::array<std::vector<render::MeshUpdate>, kMeshes> meshes_of_field(const dvec3& lo, const dvec3& hi, double voxel,
                                                                     const std::array<float, kMeshes>& tolerances,
                                                                     Distance&& distance, Label&& label,
                                                                     Wanted&& wanted) {
  // The bodies that are meshed here are round, so their meshes must have no creases (sharp edges). The mesher searches
  // for creases only where the slope of the distance field is 1. So the field is multiplied by kFlat, which keeps its
  // slope below 1 everywhere.
  constexpr float kFlat = 0.3f, kBand = 4 * kFlat;
  const VoxelFrame frame{lo, voxel};
  const glm::ivec3 bricks(glm::ceil((hi - lo) / (voxel * FieldBrick::kCells)));
  /// number of samples per axis; the cells of all bricks need one sample before the first cell, and two after the last
  const glm::ivec3 size = bricks * FieldBrick::kCells + 3;
  constexpr float kUnknown = 1e9f;
  std::vector<float> samples(static_cast<std::size_t>(size.x) * size.y * size.z, kUnknown);
  const auto at = [&](const glm::ivec3& i) {
    return (static_cast<std::size_t>(i.x) * size.y + static_cast<std::size_t>(i.y)) * size.z +
           static_cast<std::size_t>(i.z);
  };
  glm::ivec3 i;
  const auto value = [&](const dvec3& index) {
    return kFlat * static_cast<float>(distance(frame.to_world(index - 1.0)) / voxel);
  };
  // The samples are computed in blocks. A block is computed when one of its samples is first needed. If the block is
  // far from the surface, all its samples get the same value.
  const auto sample = [&](const glm::ivec3& index) {
    constexpr int kBlock = 4;
    float& known = samples[at(index)];
    if (known != kUnknown) return known;
    const glm::ivec3 first = index / kBlock * kBlock, end = glm::min(first + kBlock, size);
    const float middle = value(dvec3(first) + 0.5 * (kBlock - 1));
    constexpr double kRadius = 0.5 * (kBlock - 1) * 1.7321;
    const bool far = std::abs(middle) > kBand + kFlat * kSteepest * kRadius;
    for (glm::ivec3 j = first; j.x < end.x; ++j.x)
      for (j.y = first.y; j.y < end.y; ++j.y)
        for (j.z = first.z; j.z < end.z; ++j.z)
          samples[at(j)] = std::clamp(far ? middle : value(dvec3(j)), -kBand, kBand);
    return known;
  };

  std::vector<surface::SurfaceMesher> meshers;
  for (const float tolerance : tolerances) meshers.emplace_back(surface::MesherOptions{.tolerance = tolerance});
  FieldBrick brick;
  glm::ivec3 key;
  for (key.x = 0; key.x < bricks.x; ++key.x)
    for (key.y = 0; key.y < bricks.y; ++key.y)
      for (key.z = 0; key.z < bricks.z; ++key.z) {
        const glm::ivec3 first = key * FieldBrick::kCells;
        if (!wanted(frame.to_world(dvec3(first)), frame.to_world(dvec3(first + FieldBrick::kCells)))) continue;
        bool inside = false, outside = false;
        for (i.x = 0; i.x < FieldBrick::kSamples; ++i.x)
          for (i.y = 0; i.y < FieldBrick::kSamples; ++i.y)
            for (i.z = 0; i.z < FieldBrick::kSamples; ++i.z) {
              const float d = sample(first + i);
              brick.distance[FieldBrick::at(i.x, i.y, i.z)] = d;
              (d < 0 ? inside : outside) = true;
            }
        if (!inside || !outside) continue;
        brick.key = key;
        for (i.x = 0; i.x < FieldBrick::kSamples; ++i.x)
          for (i.y = 0; i.y < FieldBrick::kSamples; ++i.y)
            for (i.z = 0; i.z < FieldBrick::kSamples; ++i.z) {
              const std::size_t s = FieldBrick::at(i.x, i.y, i.z);
              brick.tissue[s] =
                  std::abs(brick.distance[s]) < 3 * kFlat ? label(frame.to_world(dvec3(first + i - 1))) : Tissue::kAir;
            }
        for (surface::SurfaceMesher& mesher : meshers) mesher.put(brick);
      }
  std::array<std::vector<render::MeshUpdate>, kMeshes> updates;
  for (std::size_t m = 0; m < kMeshes; ++m)
    meshers[m].remesh([&](const surface::BrickMesh& mesh) { updates[m].push_back(brick_update(mesh, voxel)); });
  return updates;
}

template <std::size_t kMeshes, class Distance, class Label>
std::array<std::vector<render::MeshUpdate>, kMeshes> meshes_of_field(const dvec3& lo, const dvec3& hi, double voxel,
                                                                     const std::array<float, kMeshes>& tolerances,
                                                                     Distance&& distance, Label&& label) {
  return meshes_of_field<kMeshes>(lo, hi, voxel, tolerances, distance, label,
                                  [](const dvec3&, const dvec3&) { return true; });
}

/// Makes a single mesh. See meshes_of_field() above for the parameters.
template <class Distance, class Label>
std::vector<render::MeshUpdate> mesh_of_field(const dvec3& lo, const dvec3& hi, double voxel, float tolerance,
                                              Distance&& distance, Label&& label) {
  return meshes_of_field<1>(lo, hi, voxel, {tolerance}, distance, label)[0];
}

}  // namespace typodont
