#include "engine/app/task/tissue_edit.h"

#include <algorithm>

#include "haptics/solid.h"

namespace typodont {

DenseCopy dense_copy(const haptics::TissueVolume& volume) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  return dense_copy(volume, lo - 2, hi - lo + 5);
}

DenseCopy dense_copy(const haptics::TissueVolume& volume, const glm::ivec3& lo, const glm::ivec3& size) {
  DenseCopy copy;
  copy.frame = {volume.frame().to_world(dvec3(lo)), volume.frame().voxel};
  copy.field.size = size;
  const std::size_t count =
      static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z);
  copy.field.distance.resize(count);
  copy.tissue.resize(count);
  volume.copy(lo, size, copy.field.distance.data(), copy.tissue.data());
  return copy;
}

haptics::TissueVolume from_dense(const DenseCopy& copy, double band) {
  haptics::DenseTissue dense;
  dense.frame = copy.frame;
  dense.size = copy.field.size;
  dense.band = band;
  dense.exact_outside = false;
  dense.tissue = copy.tissue;
  dense.distance.reserve(copy.field.distance.size());
  for (const float d : copy.field.distance) {
    dense.distance.push_back(static_cast<float>(std::clamp(static_cast<double>(d) * copy.frame.voxel, -band, band)));
  }
  return haptics::TissueVolume(dense);
}

haptics::TissueVolume without_solid(const haptics::TissueVolume& volume, const haptics::Solid& solid) {
  DenseCopy copy = dense_copy(volume);
  const glm::ivec3 n = copy.field.size;
  for (int x = 0; x < n.x; ++x) {
    for (int y = 0; y < n.y; ++y) {
      for (int z = 0; z < n.z; ++z) {
        float& d = copy.field.distance[copy.field.at(x, y, z)];
        d = std::max(d, static_cast<float>(-solid.distance(copy.frame.to_world(dvec3(x, y, z))) / copy.frame.voxel));
      }
    }
  }
  return from_dense(copy, volume.band());
}

}  // namespace typodont
