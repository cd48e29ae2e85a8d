#include "haptics/import/unseen_canals.h"

#include <cmath>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/voxels.h"

namespace typodont::haptics::importing {

namespace {

// Returns the axis along which the voxels inside the tooth extend farthest.
int longest_axis(const DenseTissue& t) {
  glm::ivec3 lo = t.size, hi(-1);
  for_each_voxel(t.size, [&](int x, int y, int z) {
    if (t.distance[t.at(x, y, z)] >= 0) return;
    lo = glm::min(lo, glm::ivec3(x, y, z));
    hi = glm::max(hi, glm::ivec3(x, y, z));
  });
  const glm::ivec3 edge = hi - lo;
  return edge.z >= edge.x && edge.z >= edge.y ? 2 : edge.y >= edge.x ? 1 : 0;
}

}  // namespace

double unseen_canal_volume(const DenseTissue& tooth, double diameter) {
  const int along = longest_axis(tooth), u = (along + 1) % 3, v = (along + 2) % 3;
  const double cross_section = M_PI / 4 * diameter * diameter, voxel = tooth.frame.voxel;
  const auto min_voxels = static_cast<std::size_t>(std::ceil(cross_section / (voxel * voxel)));
  std::size_t root_slices = 0;  // number of areas of roots without pulp, over all slices
  std::vector<char> seen;
  std::vector<glm::ivec3> area;
  for (int slice = 0; slice < tooth.size[along]; ++slice) {
    seen.assign(static_cast<std::size_t>(tooth.size[u]) * static_cast<std::size_t>(tooth.size[v]), 0);
    // Marks a voxel inside the tooth as seen and adds it to `area`, a connected area of the slice.
    const auto visit = [&](const glm::ivec3& p) {
      if (p[u] < 0 || p[v] < 0 || p[u] >= tooth.size[u] || p[v] >= tooth.size[v]) return;
      char& mark = seen[static_cast<std::size_t>(p[u]) * static_cast<std::size_t>(tooth.size[v]) +
                        static_cast<std::size_t>(p[v])];
      if (mark || tooth.distance[tooth.at(p.x, p.y, p.z)] >= 0) return;
      mark = 1;
      area.push_back(p);
    };
    for (int i = 0; i < tooth.size[u]; ++i) {
      for (int j = 0; j < tooth.size[v]; ++j) {
        glm::ivec3 first;
        first[along] = slice, first[u] = i, first[v] = j;
        area.clear();
        visit(first);
        bool only_dentin = true;
        for (std::size_t k = 0; k < area.size(); ++k) {  // `area` grows during the loop
          const glm::ivec3 p = area[k];
          only_dentin = only_dentin && tooth.tissue[tooth.at(p.x, p.y, p.z)] == Tissue::kDentin;
          for (const int axis : {u, v}) {
            for (const int step : {-1, 1}) {
              glm::ivec3 next = p;
              next[axis] += step;
              visit(next);
            }
          }
        }
        root_slices += only_dentin && area.size() >= min_voxels;
      }
    }
  }
  return cross_section * voxel * static_cast<double>(root_slices);
}

}  // namespace typodont::haptics::importing
