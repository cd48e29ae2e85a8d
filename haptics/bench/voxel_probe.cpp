#include "haptics/bench/voxel_probe.h"

#include <cmath>
#include <cstddef>

namespace typodont::haptics::bench {

VoxelProbe::VoxelProbe(const DenseTissue& dense, double radius, const dvec3& start)
    : frame_(dense.frame), size_(dense.size), radius_(radius / dense.frame.voxel), c_(frame_.to_voxels(start)) {
  for (const float d : dense.distance) full_.push_back(d < 0);
}

dvec3 VoxelProbe::push(const dvec3& p_WT) {
  const dvec3 goal = frame_.to_voxels(p_WT);
  dvec3 aim = goal;
  for (int plane = 0; plane < 3; ++plane) {
    if (!march(aim)) break;
    dvec3 n;
    probe(c_, radius_ + 1, &n);
    const double below = glm::dot(goal - c_, n);
    if (below >= 0) break;
    aim = goal + (0.5 - below) * n;  // half a voxel off the plane: a proxy that rests on full voxels sticks to them
  }
  return c_ - goal;
}

bool VoxelProbe::probe(const dvec3& c, double radius, dvec3* n) const {
  const glm::ivec3 lo = glm::max(glm::ivec3(glm::ceil(c - radius)), 0);
  const glm::ivec3 hi = glm::min(glm::ivec3(glm::floor(c + radius)), size_ - 1);
  dvec3 sum(0);
  bool hit = false;
  for (int x = lo.x; x <= hi.x; ++x) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int z = lo.z; z <= hi.z; ++z) {
        if (!full_[(static_cast<std::size_t>(x) * size_.y + y) * size_.z + z]) continue;
        const dvec3 d = c - dvec3(x, y, z);
        if (glm::dot(d, d) > radius * radius) continue;
        if (!n) return true;
        hit = true;
        sum += d;
      }
    }
  }
  if (n) *n = hit ? glm::normalize(sum) : dvec3(0);
  return hit;
}

bool VoxelProbe::march(const dvec3& aim) {
  const dvec3 way = aim - c_;
  const int steps = static_cast<int>(std::ceil(2 * glm::length(way)));
  const dvec3 from = c_;
  for (int i = 1; i <= steps; ++i) {
    const dvec3 next = from + way * (static_cast<double>(i) / steps);
    if (probe(next, radius_, nullptr)) return true;
    c_ = next;
  }
  return false;
}

}  // namespace typodont::haptics::bench
