// Cavities with known formulas, for tests of scores: a block with its top at z = kTop, from which a shape is removed.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/voxels.h"
#include "engine/session/cavity.h"

namespace typodont::session::test {

inline constexpr double kVoxel = 0.1e-3;  // m
inline constexpr double kTop = 2.55e-3;   // m

template <class Distance>
DenseField sampled(const glm::ivec3& size, Distance distance) {
  DenseField field{size, {}};
  field.distance.resize(voxel_count(size));
  for_each_voxel(size, [&](int x, int y, int z) {
    field.distance[field.at(x, y, z)] =
        static_cast<float>(std::clamp(distance(kVoxel * dvec3(x, y, z)) / kVoxel, -15.0, 15.0));
  });
  return field;
}

/// Number of samples of the block, which is 8 × 8 × 4 mm large and consists of dentin. The origin of frame W is sample
/// (0,0,0). `removed` in without(): signed distance of the removed shape.
inline const glm::ivec3 kBlock{81, 81, 41};
inline const dvec3 kMiddle{4e-3, 4e-3, kTop};
inline double block(const dvec3& p) {
  return p.z - kTop;
}

template <class Removed>
DenseField without(Removed removed) {
  return sampled(kBlock, [&](const dvec3& p) { return std::max(block(p), -removed(p)); });
}

inline CavityMeasures measure_cavity(const Preparation& preparation) {
  return measure_against_ideal(preparation, cavity_reference(preparation)).result;
}

inline Preparation a_block() {
  Preparation in;
  in.frame = {dvec3(0), kVoxel};
  in.before = sampled(kBlock, block);
  in.after = in.before;
  in.tissue.assign(in.before.distance.size(), Tissue::kDentin);
  return in;
}

/// Returns the signed distance of a box with axis +z. Its floor lies `depth` below the top and has the width 2·half.
/// Its walls lean outward by `lean` (rad).
inline auto tapered_box(const glm::dvec2& half, double depth, double lean, dvec3 middle = kMiddle) {
  return [=](const dvec3& p) {
    const double up = p.z - (middle.z - depth);
    const double x = (std::abs(p.x - middle.x) - half.x - up * std::tan(lean)) * std::cos(lean);
    const double y = (std::abs(p.y - middle.y) - half.y - up * std::tan(lean)) * std::cos(lean);
    return std::max({x, y, -up});
  };
}
inline auto tapered_hole(double radius, double depth, double lean, dvec3 middle = kMiddle) {
  return [=](const dvec3& p) {
    const double up = p.z - (middle.z - depth);
    const double wall = (std::hypot(p.x - middle.x, p.y - middle.y) - radius - up * std::tan(lean)) * std::cos(lean);
    return std::max(wall, -up);
  };
}
inline auto ball(const dvec3& center, double radius) {
  return [=](const dvec3& p) { return glm::length(p - center) - radius; };
}

}  // namespace typodont::session::test
