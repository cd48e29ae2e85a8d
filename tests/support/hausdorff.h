// Largest distance between two meshes.
#pragma once

#include <algorithm>

#include "haptics/contact/mesh_lod/triangle_grid.h"

namespace typodont::haptics::mesh_lod {

/// Larger of the two one-sided Hausdorff distances of two meshes, m, measured at corners and midpoints of faces.
inline double hausdorff_distance(const TriangleGrid& one, const TriangleGrid& other) {
  // m, distance within which the other mesh's surface is searched
  constexpr double kFar = 20e-3;
  constexpr std::size_t kSamples = 20'000;
  double most = 0;
  const auto from = [&](const TriangleGrid& a, const TriangleGrid& b) {
    const std::size_t step = std::max<std::size_t>(1, a.size() / kSamples);
    for (std::size_t i = 0; i < a.size(); i += step) {
      const Face& f = a.face(static_cast<std::uint32_t>(i));
      for (const dvec3& p : {f.a, (f.a + f.b) / 2.0, (f.a + f.b + f.c) / 3.0})
        most = std::max(most, b.nearest(p, kFar).distance);
    }
  };
  from(one, other);
  from(other, one);
  return most;
}

}  // namespace typodont::haptics::mesh_lod
