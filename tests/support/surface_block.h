// A block of tissue from which balls are cut, and a mesher that is updated in the same way as the carver updates it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "engine/base/voxels.h"
#include "tests/support/surface_checks.h"

namespace typodont::test {

// A cube of samples from which spheres are cut as by the carver: distance = max(distance, r − |p − c|).
class CutBlock {
 public:
  explicit CutBlock(int bricks)
      : bricks_(bricks), n_(16 * bricks + 3), samples_(static_cast<std::size_t>(n_ * n_ * n_)) {
    const double middle = 8.0 * bricks, half = middle - 3.4;
    each([&](const glm::dvec3& p, float& value) {
      const glm::dvec3 d = glm::abs(p - middle) - half;
      value = static_cast<float>(std::clamp(std::max({d.x, d.y, d.z}), -4.0, 4.0));
    });
  }

  /// Cuts a ball, and returns the keys of the bricks whose samples may have changed.
  std::vector<glm::ivec3> cut(const glm::dvec3& centre, double radius) {
    const glm::ivec3 low = glm::max(glm::ivec3(-1), glm::ivec3(glm::floor(centre - radius - 4.0)));
    const glm::ivec3 high = glm::min(glm::ivec3(n_ - 2), glm::ivec3(glm::ceil(centre + radius + 4.0)));
    for_each_voxel_between(low, high, [&](int x, int y, int z) {
      const auto d = static_cast<float>(std::clamp(radius - glm::length(glm::dvec3(x, y, z) - centre), -4.0, 4.0));
      float& value = at(x, y, z);
      value = std::max(value, d);
    });
    std::vector<glm::ivec3> keys;
    for_each_voxel(glm::ivec3(bricks_), [&](int x, int y, int z) {
      const glm::ivec3 first = 16 * glm::ivec3(x, y, z) - 1, last = first + 18;
      if (glm::all(glm::lessThanEqual(first, high)) && glm::all(glm::greaterThanEqual(last, low))) {
        keys.push_back({x, y, z});
      }
    });
    return keys;
  }

  FieldBrick brick(const glm::ivec3& key) const {
    FieldBrick out;
    out.key = key;
    for_each_voxel(glm::ivec3(FieldBrick::kSamples), [&](int x, int y, int z) {
      const glm::ivec3 p = 16 * key - 1 + glm::ivec3(x, y, z);
      out.distance[FieldBrick::at(x, y, z)] = const_cast<CutBlock*>(this)->at(p.x, p.y, p.z);
      out.tissue[FieldBrick::at(x, y, z)] = p.z * 3 > n_ + p.x ? Tissue::kEnamel : Tissue::kDentin;
    });
    return out;
  }

  std::vector<glm::ivec3> keys() const {
    std::vector<glm::ivec3> all;
    for_each_voxel(glm::ivec3(bricks_), [&](int x, int y, int z) { all.push_back({x, y, z}); });
    return all;
  }
  double side() const { return 16.0 * bricks_; }

 private:
  float& at(int x, int y, int z) { return samples_[static_cast<std::size_t>(((x + 1) * n_ + y + 1) * n_ + z + 1)]; }
  template <class F>
  void each(F&& f) {
    for (int x = -1; x < n_ - 1; ++x) {
      for (int y = -1; y < n_ - 1; ++y) {
        for (int z = -1; z < n_ - 1; ++z) f(glm::dvec3(x, y, z), at(x, y, z));
      }
    }
  }
  int bricks_, n_;
  std::vector<float> samples_;
};

inline void put(surface::SurfaceMesher& mesher, const FieldBrick& brick) {
  if (has_surface(brick)) {
    mesher.put(brick);
  } else {
    mesher.remove(brick.key);
  }
}

/// Cuts `cuts` random balls near the surface, and updates the mesh after each. At several moments the mesh must equal
/// that of the whole block meshed from scratch, and be a closed manifold. Returns an empty text if so, otherwise a
/// description of the error.
inline std::string cut_and_compare(int cuts) {
  CutBlock block(4);
  surface::SurfaceMesher mesher({.tolerance = 0.1f});
  for (const glm::ivec3& key : block.keys()) put(mesher, block.brick(key));
  mesher.remesh();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(0, block.side()), size(0.7, 4);
  for (int cut = 1; cut <= cuts; ++cut) {
    glm::dvec3 centre(place(random), place(random), place(random));
    const int axis = cut % 3;
    const double depth = 3 + 6.0 * cut / cuts;  // in voxels; the cuts go deeper and deeper
    centre[axis] = cut % 6 < 3 ? depth : block.side() - depth;
    for (const glm::ivec3& key : block.cut(centre, size(random))) put(mesher, block.brick(key));
    mesher.remesh();
    if (cut != 10 && cut != cuts / 10 && cut != cuts) continue;
    surface::SurfaceMesher whole({.tolerance = 0.1f});
    for (const glm::ivec3& key : block.keys()) put(whole, block.brick(key));
    whole.remesh();
    const std::string when = " after " + std::to_string(cut) + " cuts";
    if (triangle_count(mesher) < 1000) return "hardly a triangle left" + when;
    if (mesh_hash(mesher) != mesh_hash(whole) || mesher.keys() != whole.keys()) return "the meshes differ" + when;
    const Topology t = topology_of(surface::weld(mesher));
    if (!(t.closed && t.oriented && t.manifold)) return t.complaint + when;
  }
  return "";
}

}  // namespace typodont::test
