#include "haptics/contact/packing/sphere_field.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace typodont::haptics::packing {

RasterBlock SphereField::samples(const glm::ivec3& lo, const glm::ivec3& size) {
  RasterBlock block{lo, size, {}};
  block.distance.resize(static_cast<std::size_t>(size.x) * size.y * size.z);
  const VoxelFrame& frame = untouched_.frame();
  untouched_.copy(lo, size, block.distance.data(), nullptr);

  const dvec3 middle = frame.to_world(dvec3(lo) + 0.5 * dvec3(size - 1));
  const double reach = 0.5 * glm::length(dvec3(size - 1)) * frame.voxel + kMargin * frame.voxel;
  const std::size_t count = std::min(original_.near_segment(middle, middle, reach, near_), near_.size());
  const std::span<const int> near(near_.data(), count);
  const auto is_cut = [&](int i) {
    const CutSphere& s = spheres_.sphere(i);
    return s.overlap > 0 || s.base_radius != packing_.radius[static_cast<std::size_t>(i)];
  };
  if (std::none_of(near.begin(), near.end(), is_cut)) return block;

  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z) {
        const dvec3 p = frame.to_world(dvec3(lo + glm::ivec3(x, y, z)));
        double left = reach, gone = reach;  // m, to the nearest sphere's remains, and to the nearest of what is gone
        for (const int i : near) {
          const auto k = static_cast<std::size_t>(i);
          const double whole = glm::distance(p, packing_.center[k]) - packing_.radius[k];
          if (!is_cut(i)) {
            left = std::min(left, whole);
            continue;
          }
          // Each cut took what lies before a plane: the one that made `base` of the packed sphere, and the one since.
          const CutSphere& s = spheres_.sphere(i);
          const dvec3 moved = s.base - packing_.center[k];
          const double way = glm::length(moved), first = 2 * (packing_.radius[k] - s.base_radius);
          double rest = whole;
          const auto cut = [&](const dvec3& center, double radius, const dvec3& away, double overlap) {
            const double beyond = overlap - radius - glm::dot(p - center, away);
            gone = std::min(gone, std::max(whole, -beyond));
            rest = std::max(rest, beyond);
          };
          if (way > 0) cut(packing_.center[k], packing_.radius[k], moved / way, first);
          if (s.overlap > 0) cut(s.base, s.base_radius, s.away, s.overlap);
          if (spheres_.tree().radius(i) > 0) left = std::min(left, rest);
        }
        float& d = block.distance[(static_cast<std::size_t>(x) * size.y + static_cast<std::size_t>(y)) * size.z +
                                  static_cast<std::size_t>(z)];
        d = std::max(d, static_cast<float>(0.5 * (left - gone) / frame.voxel));
      }
    }
  }
  return block;
}

}  // namespace typodont::haptics::packing
