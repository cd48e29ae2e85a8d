// Makes the flat face where a plane cuts a solid, coloured by its tissues. Functions describe the solid.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"
#include "engine/render/renderer.h"

namespace typodont {

/// A plane. The part with normal · p > offset is kept; a viewer on the other side sees the face.
struct CutPlane {
  dvec3 normal;
  double offset;  // m, the plane's distance from the origin along its normal
  // The face lies this far inside the kept part, m. Exactly on the plane, clipping would remove it. A strip of this
  // width of the body's inner surface remains visible beside it.
  double within = 0.2e-6;
};

/// The tissue with the largest fraction, except air and `except`. Air if there is none.
inline std::size_t commonest(const std::array<double, kTissueCount>& fractions, std::size_t except = 0) {
  std::size_t best = 0;
  for (std::size_t t = 1; t < fractions.size(); ++t)
    if (t != except && fractions[t] > (best ? fractions[best] : 0.0)) best = t;
  return best;
}

/// Makes the flat face where `plane` cuts the tissue, inside a box (m, frame W), of cells of size `step` (m). Vertices
/// are relative to `origin`. `distance(p)`: m, negative in tissue; `fractions(p)`: fractions of the tissues around p.
template <class Distance, class Fractions>
std::vector<render::MeshUpdate> plane_face(const CutPlane& plane, const dvec3& box_lo, const dvec3& box_hi, double step,
                                           const dvec3& origin, Distance&& distance, Fractions&& fractions) {
  /// Number of cells along each side of a mesh. The face is split into meshes, so that hidden ones can be skipped.
  constexpr int kTile = 48;
  const dvec3 n = glm::normalize(plane.normal);
  const dvec3 u = glm::normalize(std::abs(n.z) < 0.9 ? glm::cross(dvec3(0, 0, 1), n) : glm::cross(dvec3(0, 1, 0), n));
  const dvec3 v = glm::cross(n, u);  // so that u × v = n
  // Finds the plane's rectangle that contains the box's section.
  glm::dvec2 lo(1e9), hi(-1e9);
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 p(corner & 1 ? box_hi.x : box_lo.x, corner & 2 ? box_hi.y : box_lo.y, corner & 4 ? box_hi.z : box_lo.z);
    const glm::dvec2 at(glm::dot(p, u), glm::dot(p, v));
    lo = glm::min(lo, at);
    hi = glm::max(hi, at);
  }
  const glm::ivec2 cells = glm::ivec2(glm::ceil((hi - lo) / step));
  struct Sample {
    dvec3 p;
    double d;
    std::array<double, kTissueCount> fractions;
  };
  const auto sample = [&](const glm::dvec2& at) {
    Sample s{n * (plane.offset + plane.within) + u * at.x + v * at.y, 0, {}};
    s.d = distance(s.p);
    if (s.d < step) s.fractions = fractions(s.p);
    return s;
  };

  std::vector<render::MeshUpdate> updates;
  for (int tile_x = 0; tile_x < cells.x; tile_x += kTile)
    for (int tile_y = 0; tile_y < cells.y; tile_y += kTile) {
      render::MeshUpdate update;
      update.brick = (static_cast<std::uint64_t>(tile_x) << 32) | static_cast<std::uint64_t>(tile_y);
      const int nx = std::min(kTile, cells.x - tile_x), ny = std::min(kTile, cells.y - tile_y);
      std::vector<Sample> grid;
      for (int i = 0; i <= nx; ++i)
        for (int j = 0; j <= ny; ++j) grid.push_back(sample(lo + step * glm::dvec2(tile_x + i, tile_y + j)));
      for (int i = 0; i < nx; ++i)
        for (int j = 0; j < ny; ++j) {
          const auto at = [&](int a, int b) -> const Sample& {
            return grid[static_cast<std::size_t>(i + a) * (ny + 1) + static_cast<std::size_t>(j + b)];
          };
          const std::array<const Sample*, 4> corners{&at(0, 0), &at(1, 0), &at(1, 1), &at(0, 1)};
          // Polygon of the cell's part in the tissue: corners inside and crossings of the outline, in order around the
          // cell.
          std::array<Sample, 8> part;
          std::size_t count = 0;
          std::array<double, kTissueCount> sum{};
          for (std::size_t k = 0; k < 4; ++k) {
            const Sample &a = *corners[k], &b = *corners[(k + 1) % 4];
            if (a.d < 0) part[count++] = a;
            if ((a.d < 0) != (b.d < 0))
              part[count++] = sample([&] {
                const dvec3 p = glm::mix(a.p, b.p, a.d / (a.d - b.d));
                return glm::dvec2(glm::dot(p, u), glm::dot(p, v));
              }());
          }
          if (count < 3) continue;
          for (std::size_t k = 0; k < count; ++k)
            for (std::size_t t = 1; t < sum.size(); ++t) sum[t] += part[k].fractions[t];
          const std::size_t first = commonest(sum), second = commonest(sum, first);
          if (!first) continue;
          const auto base = static_cast<std::uint32_t>(update.vertices.size());
          for (std::size_t k = 0; k < count; ++k) {
            render::Vertex vertex;
            vertex.p = glm::vec3(part[k].p - origin);
            vertex.n = glm::vec3(-n);
            vertex.tissue = {static_cast<Tissue>(first), static_cast<Tissue>(second ? second : first)};
            const double a = part[k].fractions[first], b = second ? part[k].fractions[second] : 0;
            vertex.second = static_cast<float>(a + b > 0 ? b / (a + b) : 0);
            update.vertices.push_back(vertex);
          }
          // The viewer looks along the normal, so the order of the corners is reversed.
          for (std::uint32_t k = 1; k + 1 < count; ++k)
            update.indices.insert(update.indices.end(), {base, base + k + 1, base + k});
        }
      if (!update.indices.empty()) updates.push_back(std::move(update));
    }
  return updates;
}

}  // namespace typodont
