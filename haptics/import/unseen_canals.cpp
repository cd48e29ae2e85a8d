#include "haptics/import/unseen_canals.h"

#include <cmath>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/voxels.h"
#include "haptics/import/blocks.h"

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
  for (int slice = 0; slice < tooth.size[along]; ++slice) {
    Mask inside(glm::ivec3(tooth.size[u], tooth.size[v], 1), 0);
    // Index of a sample of the slice in the tooth.
    const auto at = [&](std::size_t i) {
      glm::ivec3 p;
      p[along] = slice, p[u] = inside.place(i).x, p[v] = inside.place(i).y;
      return tooth.at(p.x, p.y, p.z);
    };
    for (std::size_t i = 0; i < inside.v.size(); ++i) inside.v[i] = tooth.distance[at(i)] < 0;
    const SparseComponents areas = components(inside);
    std::vector<bool> only_dentin(areas.voxels.size(), true);
    for (std::size_t i = 0; i < inside.v.size(); ++i) {
      if (tooth.tissue[at(i)] != Tissue::kDentin)
        only_dentin[static_cast<std::size_t>(areas.label[inside.place(i)])] = false;
    }
    for (std::size_t id = 1; id < areas.voxels.size(); ++id)
      root_slices += only_dentin[id] && areas.voxels[id] >= min_voxels;
  }
  return cross_section * voxel * static_cast<double>(root_slices);
}

}  // namespace typodont::haptics::importing
