// Meshes bodies that have no contact and are only drawn. Functions of a position in frame W describe the bodies.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "engine/app/tissue/brick_update.h"
#include "engine/base/voxels.h"
#include "engine/surface/surface_mesher.h"

namespace typodont {

/// Replaces normals by the gradient of the distance function, because the mesher mistakes bends of a coarse mesh for
/// creases. Normals at real creases remain. `lo`: origin of the vertices, m, frame W. `step`: step of the central
/// differences, m.
template <class Distance>
void shade_by_slope(std::vector<render::MeshUpdate>& bricks, const dvec3& lo, double step, Distance&& distance) {
  /// If the cosine between the mesher's normal and the gradient is smaller than this, the vertex is at a crease.
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

constexpr double kSteepest = 1.5;  // m per m, largest slope of a body's distance function

/// Meshes a body in the box from `lo` to `hi` (m, frame W), once for each entry of `tolerances` (voxels). Vertices are
/// relative to `lo`. `distance(p)`: m, negative inside, slope at most kSteepest. `label(p)`: tissue. `wanted(lo, hi)`:
/// false for boxes to skip.
template <std::size_t kMeshes, class Distance, class Label, class Wanted>
std::array<std::vector<render::MeshUpdate>, kMeshes> meshes_of_field(const dvec3& lo, const dvec3& hi, double voxel,
                                                                     const std::array<float, kMeshes>& tolerances,
                                                                     Distance&& distance, Label&& label,
                                                                     Wanted&& wanted) {
  // Round bodies need no creases. The mesher searches for creases only where the field's slope is 1, so kFlat scales
  // all distances. kBand: largest scaled distance, voxels.
  constexpr float kFlat = 0.3f, kBand = 4 * kFlat;
  const VoxelFrame frame{lo, voxel};
  const glm::ivec3 bricks(glm::ceil((hi - lo) / (voxel * FieldBrick::kCells)));
  /// Number of samples per axis: one before the first cell, two after the last.
  const glm::ivec3 size = bricks * FieldBrick::kCells + 3;
  constexpr float kUnknown = 1e9f;
  std::vector<float> samples(voxel_count(size), kUnknown);
  const auto value = [&](const dvec3& index) {
    return kFlat * static_cast<float>(distance(frame.to_world(index - 1.0)) / voxel);
  };
  // Computes a block of samples when one of them is first needed. Far from the surface, one value fills the block.
  const auto sample = [&](const glm::ivec3& index) {
    constexpr int kBlock = 4;
    float& known = samples[voxel_index(index, size)];
    if (known != kUnknown) return known;
    const glm::ivec3 first = index / kBlock * kBlock, end = glm::min(first + kBlock, size);
    const float middle = value(dvec3(first) + 0.5 * (kBlock - 1));
    constexpr double kRadius = 0.5 * (kBlock - 1) * 1.7321;
    const bool far = std::abs(middle) > kBand + kFlat * kSteepest * kRadius;
    for_each_voxel_between(first, end - 1, [&](const glm::ivec3& i) {
      samples[voxel_index(i, size)] = std::clamp(far ? middle : value(dvec3(i)), -kBand, kBand);
    });
    return known;
  };

  std::vector<surface::SurfaceMesher> meshers;
  for (const float tolerance : tolerances) meshers.emplace_back(surface::MesherOptions{.tolerance = tolerance});
  FieldBrick brick;
  for_each_voxel(bricks, [&](const glm::ivec3& key) {
    const glm::ivec3 first = key * FieldBrick::kCells, samples_of_brick(FieldBrick::kSamples);
    if (!wanted(frame.to_world(dvec3(first)), frame.to_world(dvec3(first + FieldBrick::kCells)))) return;
    bool inside = false, outside = false;
    for_each_voxel(samples_of_brick, [&](const glm::ivec3& i) {
      const float d = sample(first + i);
      brick.distance[FieldBrick::at(i.x, i.y, i.z)] = d;
      (d < 0 ? inside : outside) = true;
    });
    if (!inside || !outside) return;
    brick.key = key;
    for_each_voxel(samples_of_brick, [&](const glm::ivec3& i) {
      const std::size_t s = FieldBrick::at(i.x, i.y, i.z);
      brick.tissue[s] =
          std::abs(brick.distance[s]) < 3 * kFlat ? label(frame.to_world(dvec3(first + i - 1))) : Tissue::kAir;
    });
    for (surface::SurfaceMesher& mesher : meshers) mesher.put(brick);
  });
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
