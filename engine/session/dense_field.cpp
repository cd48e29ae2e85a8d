#include "engine/session/dense_field.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

namespace typodont::session {

namespace {

// voxels. For every voxel, redistanced() first takes the surface point of the nearest seed (a voxel next to the
// surface). If this point is nearer to the voxel than this limit, the point is then moved towards the voxel's own
// closest surface point.
constexpr float kRefineLimit = 20;
// voxels; samples nearer to the surface than this keep their old distances. The value is larger than a voxel's diagonal
// (1.73), so all corners of a voxel that the surface crosses keep their distances.
constexpr float kUnchangedBand = 1.8f;

/// Finds for every voxel its nearest seed, by passing seeds from voxel to neighbouring voxel. A seed is either a voxel
/// whose closest surface point is known, or a marked voxel. There are eight passes over all voxels, one for each
/// combination of ascending and descending axes. `closer(p, to, from)` compares the seeds of two neighbours: if the
/// seed of the voxel `from` is nearer to the voxel `to` (at p) than the present seed of `to`, the voxel `to`
/// gets the seed of `from`.
template <class Closer>
void sweep_all(const glm::ivec3& size, Closer&& closer) {
  const auto n = glm::ivec3(size);
  const std::size_t step[3] = {static_cast<std::size_t>(n.y) * static_cast<std::size_t>(n.z),
                               static_cast<std::size_t>(n.z), 1};
  for (int pass = 0; pass < 8; ++pass) {
    const bool up[3] = {(pass & 1) == 0, (pass & 2) == 0, (pass & 4) == 0};
    for (int a = 0; a < n.x; ++a) {
      const int x = up[0] ? a : n.x - 1 - a;
      for (int b = 0; b < n.y; ++b) {
        const int y = up[1] ? b : n.y - 1 - b;
        for (int c = 0; c < n.z; ++c) {
          const int z = up[2] ? c : n.z - 1 - c;
          const std::size_t at = static_cast<std::size_t>(x) * step[0] + static_cast<std::size_t>(y) * step[1] +
                                 static_cast<std::size_t>(z);
          if (a > 0) closer(glm::ivec3(x, y, z), at, up[0] ? at - step[0] : at + step[0]);
          if (b > 0) closer(glm::ivec3(x, y, z), at, up[1] ? at - step[1] : at + step[1]);
          if (c > 0) closer(glm::ivec3(x, y, z), at, up[2] ? at - step[2] : at + step[2]);
        }
      }
    }
  }
}

}  // namespace

double DenseField::sample(const glm::dvec3& p) const {
  const glm::dvec3 q = glm::clamp(p, glm::dvec3(0), glm::dvec3(size - 1));
  const glm::ivec3 i = glm::min(glm::ivec3(q), glm::max(size - 2, glm::ivec3(0)));
  const glm::ivec3 j = glm::min(i + 1, size - 1);
  const glm::dvec3 f = q - glm::dvec3(i);
  const auto v = [&](int x, int y, int z) { return static_cast<double>(distance[at(x, y, z)]); };
  const auto line = [&](int x, int y) { return v(x, y, i.z) + f.z * (v(x, y, j.z) - v(x, y, i.z)); };
  const double a = line(i.x, i.y) + f.y * (line(i.x, j.y) - line(i.x, i.y));
  const double b = line(j.x, i.y) + f.y * (line(j.x, j.y) - line(j.x, i.y));
  return a + f.x * (b - a);
}

glm::dvec3 DenseField::gradient(const glm::dvec3& p, double reach) const {
  glm::dvec3 g;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 d(0);
    d[axis] = reach;
    g[axis] = (sample(p + d) - sample(p - d)) / (2 * reach);
  }
  return g;
}

double fraction_inside(double distance) {
  return std::clamp(0.5 - distance, 0.0, 1.0);
}

DenseField redistanced(const DenseField& field) {
  const glm::ivec3 n = field.size;
  const std::size_t count = field.distance.size();
  constexpr float kFar = 1e6f;
  /// A voxel next to the surface, its closest point on the surface, and the surface's normal there.
  struct Seed {
    std::size_t voxel;
    glm::vec3 closest;
    std::optional<glm::dvec3> normal;  // not if the gradient is too small for a direction
  };
  const auto normal_at = [&](const glm::dvec3& p) {
    const glm::dvec3 g = field.gradient(p);
    return glm::length(g) > 0.5 ? std::optional(glm::normalize(g)) : std::nullopt;
  };
  std::vector<Seed> seeds;
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> nearest(count, kNone);  // index of the nearest seed
  std::vector<float> best(count, kFar);              // voxels, distance to the closest point of that seed

  // The closest point of a seed is computed from the gradient.
  const auto inside = [&](int x, int y, int z) { return field.distance[field.at(x, y, z)] < 0; };
  for (int x = 0; x < n.x; ++x) {
    for (int y = 0; y < n.y; ++y) {
      for (int z = 0; z < n.z; ++z) {
        const bool in = inside(x, y, z);
        const bool border = (x > 0 && inside(x - 1, y, z) != in) || (x + 1 < n.x && inside(x + 1, y, z) != in) ||
                            (y > 0 && inside(x, y - 1, z) != in) || (y + 1 < n.y && inside(x, y + 1, z) != in) ||
                            (z > 0 && inside(x, y, z - 1) != in) || (z + 1 < n.z && inside(x, y, z + 1) != in);
        if (!border) continue;
        const std::size_t at = field.at(x, y, z);
        const glm::dvec3 p(x, y, z);
        const glm::dvec3 g = field.gradient(p);
        const double length = glm::length(g), d = static_cast<double>(field.distance[at]);
        const glm::vec3 closest(length > 0.1 ? p - std::clamp(d, -1.5, 1.5) * g / length : p);
        nearest[at] = static_cast<std::uint32_t>(seeds.size());
        best[at] = std::abs(field.distance[at]);
        seeds.push_back({at, closest, {}});
      }
    }
  }
  for (Seed& seed : seeds) seed.normal = normal_at(glm::dvec3(seed.closest));
  sweep_all(n, [&](const glm::ivec3& p, std::size_t to, std::size_t from) {
    if (best[from] >= kFar) return;
    // A voxel already has its distance to its seed, except the seed itself, which begins with the field's value.
    if (nearest[from] == nearest[to] && seeds[nearest[to]].voxel != to) return;
    const glm::vec3 d = glm::vec3(p) - seeds[nearest[from]].closest;
    const float reach = glm::dot(d, d);
    if (reach >= best[to] * best[to]) return;
    best[to] = std::sqrt(reach);
    nearest[to] = nearest[from];
  });

  // The closest point of the nearest seed is moved along the surface towards the voxel, so that it becomes the voxel's
  // own closest surface point. Many voxels have the same seed, so its normal is computed only once.
  DenseField result = field;
  for (int x = 0; x < n.x; ++x) {
    for (int y = 0; y < n.y; ++y) {
      for (int z = 0; z < n.z; ++z) {
        const std::size_t at = field.at(x, y, z);
        if (std::abs(field.distance[at]) <= kUnchangedBand) continue;
        if (best[at] >= kFar) continue;
        if (best[at] > kRefineLimit) {
          result.distance[at] = std::copysign(best[at], field.distance[at]);
          continue;
        }
        const glm::dvec3 p(x, y, z);
        const Seed& seed = seeds[nearest[at]];
        glm::dvec3 c(seed.closest);
        double reach = static_cast<double>(best[at]);
        std::optional<glm::dvec3> normal = seed.normal;
        for (int k = 0; k < 2; ++k) {
          if (k > 0) normal = normal_at(c);
          if (!normal) break;
          glm::dvec3 along = p - c - glm::dot(p - c, *normal) * *normal;
          const double length = glm::length(along);
          if (length > 1) along /= length;
          const glm::dvec3 moved = c + along - field.sample(c + along) * *normal;
          const double now = glm::length(p - moved);
          if (!(now < reach) || std::abs(field.sample(moved)) > 0.05) break;
          reach = now;
          c = moved;
        }
        result.distance[at] = std::copysign(std::max(static_cast<float>(reach), kUnchangedBand), field.distance[at]);
      }
    }
  }
  return result;
}

std::vector<std::size_t> nearest_marked(const glm::ivec3& size, const std::vector<bool>& marked) {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> nearest(marked.size(), kNone);
  for (std::size_t i = 0; i < marked.size(); ++i) {
    if (marked[i]) nearest[i] = i;
  }
  const auto nz = static_cast<std::size_t>(size.z), nyz = static_cast<std::size_t>(size.y) * nz;
  const auto square = [&](const glm::ivec3& p, std::size_t i) {
    const glm::ivec3 d =
        p - glm::ivec3(static_cast<int>(i / nyz), static_cast<int>(i % nyz / nz), static_cast<int>(i % nz));
    return static_cast<std::int64_t>(d.x) * d.x + static_cast<std::int64_t>(d.y) * d.y +
           static_cast<std::int64_t>(d.z) * d.z;
  };
  sweep_all(size, [&](const glm::ivec3& p, std::size_t to, std::size_t from) {
    if (nearest[from] == kNone || nearest[from] == nearest[to]) return;
    if (nearest[to] == kNone || square(p, nearest[from]) < square(p, nearest[to])) nearest[to] = nearest[from];
  });
  return nearest;
}

}  // namespace typodont::session
