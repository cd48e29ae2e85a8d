#include "engine/app/hands/expert_terrain.h"

#include <algorithm>
#include <cmath>

#include "engine/app/hands/stroke_planner.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/nearest.h"
#include "engine/base/voxels.h"

namespace typodont {

Terrain::Terrain(const haptics::TissueVolume& tissue, const SurroundingsShape* around, const dvec3& axis) {
  const dquat R = toward(axis);
  u_ = R * dvec3(1, 0, 0), v_ = R * dvec3(0, 1, 0), w_ = R * dvec3(0, 0, 1);
  const DenseCopy copy = dense_copy(tissue);
  dvec3 lo(1e9), hi(-1e9);
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 p = copy.frame.to_world(dvec3(corner & 1 ? copy.field.size.x : 0, corner & 2 ? copy.field.size.y : 0,
                                              corner & 4 ? copy.field.size.z : 0));
    const dvec3 q(glm::dot(p, u_), glm::dot(p, v_), glm::dot(p, w_));
    lo = glm::min(lo, q), hi = glm::max(hi, q);
  }
  lo_ = {lo.x - kRim, lo.y - kRim};
  size_ = glm::ivec2((glm::dvec2(hi) + kRim - lo_) / kCell) + 1;
  height_.assign(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y), lo.z);
  for_each_voxel(copy.field.size, [&](int x, int y, int z) {
    if (copy.field.distance[copy.field.at(x, y, z)] >= 0) return;
    const dvec3 p = copy.frame.to_world(dvec3(x, y, z));
    double& height = height_[cell(cell_of(p))];
    height = std::max(height, glm::dot(p, w_));
  });
  if (!around) return;
  for (int i = 0; i < size_.x; ++i) {
    for (int j = 0; j < size_.y; ++j) {
      double& height = height_[cell({i, j})];
      const dvec3 foot = (lo_.x + (i + 0.5) * kCell) * u_ + (lo_.y + (j + 0.5) * kCell) * v_;
      double w = hi.z + kRim;
      while (w > height && around->neighbour(foot + w * w_) > 0 && around->gum(foot + w * w_) > 0) w -= kCell;
      height = std::max(height, w);
    }
  }
}

double Terrain::highest(const dvec3& a, const dvec3& b, double beside) const {
  const glm::ivec2 ca = cell_of(a), cb = cell_of(b), around(static_cast<int>(beside / kCell) + 1);
  const glm::ivec2 lo = glm::max(glm::min(ca, cb) - around, glm::ivec2(0)),
                   hi = glm::min(glm::max(ca, cb) + around, size_ - 1);
  const double most = beside / kCell + 1;
  double highest = -1e9;
  for (int i = lo.x; i <= hi.x; ++i) {
    for (int j = lo.y; j <= hi.y; ++j) {
      if (distance_to_segment(glm::dvec2(ca), glm::dvec2(cb), glm::dvec2(i, j)) <= most)
        highest = std::max(highest, height_[cell({i, j})]);
    }
  }
  return highest;
}

}  // namespace typodont
