#include "haptics/import/distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "engine/base/nearest.h"
#include "engine/base/voxels.h"

namespace typodont::haptics::importing {

namespace {

// Index of a sample; negative: it is outside the box or not stored.
template <class T>
std::ptrdiff_t number(const Sparse<T>& g, const glm::ivec3& p) {
  return g.holds(p) ? g.index(p) : -1;
}

// Calls visit(index, position) for the stored samples with x from x_lo to x_hi − 1 among p and its 26 neighbours.
template <class T, class Visit>
void visit_around(const Sparse<T>& g, const glm::ivec3& p, int x_lo, int x_hi, Visit visit) {
  const BlockSet& set = *g.set;
  const glm::ivec3 lo = glm::max(p - 1, glm::ivec3(x_lo, 0, 0)),
                   hi = glm::min(p + 1, glm::ivec3(x_hi, set.size.y, set.size.z) - 1);
  // p and its neighbours lie in at most 2×2×2 blocks. start[k]: index of block k's first sample; -1: block not stored.
  const glm::ivec3 first = lo & ~(BlockSet::kEdge - 1);
  std::ptrdiff_t start[8];
  for (int k = 0; k < 8; ++k) {
    const glm::ivec3 at = first + BlockSet::kEdge * glm::ivec3(k >> 2, k >> 1 & 1, k & 1);
    start[k] = -1;
    if (at.x > hi.x || at.y > hi.y || at.z > hi.z) continue;
    const std::int32_t slot = set.slot[set.block(at)];
    if (slot >= 0) start[k] = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(slot) * BlockSet::kSamples);
  }
  for (int x = lo.x; x <= hi.x; ++x) {
    for (int y = lo.y; y <= hi.y; ++y) {
      const std::ptrdiff_t row = (x & 15) << 8 | (y & 15) << 4;
      const std::ptrdiff_t* of_row = &start[(x - first.x) >> 4 << 2 | (y - first.y) >> 4 << 1];
      for (int z = lo.z; z <= hi.z; ++z) {
        const std::ptrdiff_t block = of_row[(z - first.z) >> 4];
        if (block >= 0) visit(static_cast<std::size_t>(block + (row | (z & 15))), glm::ivec3(x, y, z));
      }
    }
  }
}

// Propagates the nearest feature (surface point or triangle) from `seeds` to their neighbours, nearest first, in the
// planes x_lo … x_hi − 1. Buckets of width `step` / 4 replace a priority queue.
template <class SquaredFrom>
void propagate_within(Sparse<std::int32_t>& feature, Sparse<float>& nearest, std::vector<std::uint8_t>& unpropagated,
                      int x_lo, int x_hi, const std::vector<std::size_t>& seeds, double band, double step,
                      SquaredFrom squared_from) {
  const double width = 0.25 * step;
  std::vector<std::vector<std::size_t>> buckets(static_cast<std::size_t>(band / width) + 2);
  for (const std::size_t i : seeds) {
    const auto b = static_cast<std::size_t>(nearest.v[i] / width);
    unpropagated[i] = 1;
    if (b < buckets.size()) buckets[b].push_back(i);
  }
  for (std::size_t b = 0; b < buckets.size(); ++b) {
    for (std::size_t k = 0; k < buckets[b].size(); ++k) {  // the current bucket may grow during the loop
      const std::size_t i = buckets[b][k];
      if (!std::exchange(unpropagated[i], std::uint8_t{0})) continue;
      const std::int32_t f = feature.v[i];
      const glm::ivec3 p = feature.place(i);
      const auto from = squared_from(f);
      visit_around(feature, p, x_lo, x_hi, [&](std::size_t j, const glm::ivec3& q) {
        if (feature.v[j] == f) return;
        const double squared = from(q), present = static_cast<double>(nearest.v[j]);
        if (squared >= present * present) return;
        const auto d = static_cast<float>(std::sqrt(squared));
        if (!(d < nearest.v[j])) return;
        nearest.v[j] = d;
        feature.v[j] = f;
        unpropagated[j] = 1;
        // Never an earlier bucket than the current one, because those are already processed.
        const auto into = std::max(b, static_cast<std::size_t>(d / width));
        if (into < buckets.size()) buckets[into].push_back(j);
      });
    }
    std::vector<std::size_t>().swap(buckets[b]);
  }
}

// Finds the nearest feature of each sample within `band`. `squared_from(feature)`: returns a function for the squared
// distance from the feature. Slabs are processed in parallel, and afterwards the borders between them.
template <class SquaredFrom>
void propagate(Sparse<std::int32_t>& feature, Sparse<float>& nearest, double band, double step,
               SquaredFrom squared_from) {
  // Number of samples that the band covers along an axis.
  const int reach = static_cast<int>(band / step) + 2;
  const int slab = std::max(64, (2 * reach + BlockSet::kEdge) / BlockSet::kEdge * BlockSet::kEdge);
  const int x_size = feature.set->size.x, slabs = (x_size + slab - 1) / slab;
  std::vector<std::vector<std::size_t>> seeds(static_cast<std::size_t>(slabs)), at_seam(seeds.size());
  for (std::size_t i = 0; i < feature.v.size(); ++i) {
    if (feature.v[i] >= 0) seeds[static_cast<std::size_t>(feature.place(i).x / slab)].push_back(i);
  }
  // 1: the sample's feature has not been propagated to its neighbours yet.
  std::vector<std::uint8_t> unpropagated(feature.v.size(), 0);
  for_each_in_parallel(slabs, [&](int s) {
    propagate_within(feature, nearest, unpropagated, s * slab, std::min((s + 1) * slab, x_size),
                     seeds[static_cast<std::size_t>(s)], band, step, squared_from);
  });
  for (std::size_t i = 0; i < feature.v.size(); ++i) {
    if (feature.v[i] < 0) continue;
    const int x = feature.place(i).x;
    if (x % slab == 0 && x > 0) at_seam[static_cast<std::size_t>(x / slab)].push_back(i);
    if (x % slab == slab - 1 && x + 1 < x_size) at_seam[static_cast<std::size_t>(x / slab + 1)].push_back(i);
  }
  for_each_in_parallel(slabs, [&](int s) {
    propagate_within(feature, nearest, unpropagated, s * slab - slab / 2, std::min(s * slab + slab / 2, x_size),
                     at_seam[static_cast<std::size_t>(s)], band, step, squared_from);
  });
}

// Moves x along the gradient to phi = 0 with Newton's method. Returns false if phi is flat, or without convergence.
bool project(const Sparse<float>& phi, glm::dvec3& x) {
  for (int i = 0; i < 6; ++i) {
    const Jet jet = sample_cubic(phi, x);
    const double g2 = glm::dot(jet.gradient, jet.gradient);
    if (!(g2 > 1e-8)) return false;
    glm::dvec3 step = -jet.value / g2 * jet.gradient;
    const double length = glm::length(step);
    if (length > 0.5) step *= 0.5 / length;
    x += step;
    if (length < 1e-5) return true;
  }
  return std::abs(sample_cubic(phi, x).value) < 1e-3;
}

// Moves the surface point x to the surface point closest to q. Returns false without convergence.
bool closest_point(const Sparse<float>& phi, const glm::dvec3& q, glm::dvec3& x) {
  double damping = 1;
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 24; ++i) {
    const Jet jet = sample_cubic(phi, x);
    const double g2 = glm::dot(jet.gradient, jet.gradient);
    if (!(g2 > 1e-8)) return false;
    const glm::dvec3 onto = -jet.value / g2 * jet.gradient;  // step from x towards the surface
    // Step from x towards q within the tangent plane.
    const glm::dvec3 along = (q - x) - glm::dot(q - x, jet.gradient) / g2 * jet.gradient;
    const double error = glm::length(onto) + glm::length(along);
    if (error < 2e-3) {
      x += onto;
      return true;
    }
    // Where the error hardly decreases, as near a centre of curvature, the tangential step is too long: damp it.
    if (error > 0.9 * before) damping *= 0.6;
    before = error;
    glm::dvec3 step = onto + damping * along;
    const double length = glm::length(step);
    if (length > 0.6) step *= 0.6 / length;
    x += step;
  }
  return false;
}

// Crossings of the grid lines with the surface, moved onto the tricubic interpolant.
std::vector<glm::vec3> crossings(const Sparse<float>& phi) {
  const BlockSet& set = *phi.set;
  std::vector<std::vector<glm::vec3>> found(set.first.size());
  for_each_sample(set, [&](const glm::ivec3& p, std::size_t i) {
    const float a = phi.v[i];
    for (int axis = 0; axis < 3; ++axis) {
      glm::ivec3 q = p;
      ++q[axis];
      if (!phi.holds(q)) continue;
      const float b = phi[q];
      if ((a > 0) == (b > 0)) continue;
      glm::dvec3 at(p);
      at[axis] += static_cast<double>(a) / (static_cast<double>(a) - static_cast<double>(b));
      glm::dvec3 moved = at;
      if (project(phi, moved) && glm::length(moved - at) < 1) at = moved;
      found[i / BlockSet::kSamples].push_back(glm::vec3(at));
    }
  });
  std::vector<glm::vec3> points;
  for (auto& of_block : found) {
    points.insert(points.end(), of_block.begin(), of_block.end());
    std::vector<glm::vec3>().swap(of_block);
  }
  return points;
}

}  // namespace

DistanceField signed_distance(const Sparse<float>& phi, const glm::ivec3& size, const Placement& placement, double band,
                              double exact) {
  const auto source = [&](const glm::ivec3& i) { return placement.offset + placement.scale * glm::dvec3(i); };
  const auto target = [&](const glm::vec3& p) { return (glm::dvec3(p) - placement.offset) / placement.scale; };
  std::vector<glm::vec3> points = crossings(phi);
  const double reach = band + 1.5 * placement.scale;

  // Marks the blocks that have samples near a surface point.
  const glm::ivec3 count = BlockSet::blocks_of(size);
  Grid<std::uint8_t> near(count, 0);
  for (const glm::vec3& p : points) {
    const glm::dvec3 at = target(p);
    const double samples = reach / placement.scale;
    const glm::ivec3 lo = glm::max(glm::ivec3(glm::floor((at - samples) / 16.0)), glm::ivec3(0));
    const glm::ivec3 hi = glm::min(glm::ivec3(glm::floor((at + samples) / 16.0)), count - 1);
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) { near(x, y, z) = 1; });
  }
  auto blocks = std::make_shared<BlockSet>(size, near.v);
  for (std::size_t b = 0; b < blocks->slot.size(); ++b) {
    if (blocks->slot[b] == BlockSet::kOutside && sample(phi, source(16 * near.place(b))) > 0)
      blocks->slot[b] = BlockSet::kInside;
  }
  const std::shared_ptr<const BlockSet> set = std::move(blocks);

  Sparse<std::int32_t> feature(set, -1, -1);
  DistanceField field{Sparse<float>(set, static_cast<float>(band), static_cast<float>(-band)), {}};
  Sparse<float>& d = field.distance;
  d.fill(std::numeric_limits<float>::max());
  const auto squared_from = [&](std::int32_t f) {
    return [&source, point = glm::dvec3(points[static_cast<std::size_t>(f)])](const glm::ivec3& i) {
      const glm::dvec3 off = source(i) - point;
      return glm::dot(off, off);
    };
  };
  for (std::size_t f = 0; f < points.size(); ++f) {
    const glm::ivec3 lo(glm::floor(target(points[f])));
    for (int k = 0; k < 8; ++k) {
      const glm::ivec3 q = lo + glm::ivec3(k & 1, k >> 1 & 1, k >> 2);
      const std::ptrdiff_t at = number(feature, q);
      if (at < 0) continue;
      const auto i = static_cast<std::size_t>(at);
      const auto away = static_cast<float>(std::sqrt(squared_from(static_cast<std::int32_t>(f))(q)));
      if (away < d.v[i]) {
        d.v[i] = away;
        feature.v[i] = static_cast<std::int32_t>(f);
      }
    }
  }
  propagate(feature, d, reach, placement.scale, squared_from);

  // The nearest point on the surface usually lies between the crossings, so it is refined.
  field.closest = Sparse<glm::vec3>(set, glm::vec3(0), glm::vec3(0));
  for_each_sample(*set, [&](const glm::ivec3& i, std::size_t k) {
    const glm::dvec3 q = source(i);
    // For samples far from the surface, linear interpolation is exact enough to find the sign.
    if (feature.v[k] < 0) {
      d.v[k] = static_cast<float>(sample(phi, q) > 0 ? -band : band);
      return;
    }
    const bool inside = d.v[k] < 1.5F ? sample_cubic(phi, q).value > 0 : sample(phi, q) > 0;
    glm::vec3& closest = field.closest.v[k];
    closest = points[static_cast<std::size_t>(feature.v[k])];
    double length = d.v[k];
    if (length < exact) {
      glm::dvec3 c(closest);
      if (closest_point(phi, q, c) && glm::length(q - c) <= length + 1e-3) {
        length = glm::length(q - c);
        closest = glm::vec3(c);
      }
    }
    length = std::min(length, band);
    d.v[k] = static_cast<float>(inside ? -length : length);
  });
  feature = {};
  std::vector<glm::vec3>().swap(points);

  // Takes the closest point that a neighbouring sample has found, if it is nearer to this sample.
  const auto bound = static_cast<float>(std::min(exact, band));
  for (int pass = 0; pass < 2; ++pass) {
    // The improvements are stored separately first, because threads read each other's samples.
    struct Better {
      std::size_t sample;
      float distance;
      glm::vec3 closest;
    };
    std::vector<std::vector<Better>> found(set->first.size());
    for_each_sample(*set, [&](const glm::ivec3& i, std::size_t k) {
      if (!(std::abs(d.v[k]) < bound)) return;
      const glm::dvec3 q = source(i);
      double best = std::abs(d.v[k]);
      std::optional<glm::dvec3> nearer;
      for (int n = 0; n < 6; ++n) {
        glm::ivec3 j = i;
        j[n / 2] += n % 2 ? 1 : -1;
        const std::ptrdiff_t at = number(d, j);
        if (at < 0 || !(std::abs(d.v[static_cast<std::size_t>(at)]) < static_cast<float>(band))) continue;
        glm::dvec3 c(field.closest.v[static_cast<std::size_t>(at)]);
        if (glm::length(q - c) > best - 2e-3) continue;
        best = glm::length(q - c);
        nearer = c;
        if (closest_point(phi, q, c) && glm::length(q - c) <= best) {
          best = glm::length(q - c);
          nearer = c;
        }
      }
      if (nearer)
        found[k / BlockSet::kSamples].push_back(
            {k, std::copysign(static_cast<float>(best), d.v[k]), glm::vec3(*nearer)});
    });
    for (const auto& of_block : found) {
      for (const Better& b : of_block) {
        d.v[b.sample] = b.distance;
        field.closest.v[b.sample] = b.closest;
      }
    }
  }
  return field;
}

WindingNumbers::Lines WindingNumbers::lines_along(int axis, std::span<const Triangle> mesh, const glm::ivec3& size) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  // Shifts the grid lines by a tiny irrational amount, because some meshes have vertices exactly on the grid.
  constexpr double kShiftU = 1.6180339e-6, kShiftV = 2.7182818e-6;
  struct OfLine {
    std::uint32_t line;
    Crossing crossing;
  };
  std::vector<OfLine> found;
  for (const Triangle& t : mesh) {
    const glm::dvec3* corner[3] = {&t.a, &t.b, &t.c};
    double lo[2] = {1e300, 1e300}, hi[2] = {-1e300, -1e300};
    for (const glm::dvec3* p : corner) {
      lo[0] = std::min(lo[0], (*p)[u]), hi[0] = std::max(hi[0], (*p)[u]);
      lo[1] = std::min(lo[1], (*p)[v]), hi[1] = std::max(hi[1], (*p)[v]);
    }
    const int u0 = std::max(0, static_cast<int>(std::floor(lo[0]))),
              u1 = std::min(size[u] - 1, static_cast<int>(hi[0]) + 1);
    const int v0 = std::max(0, static_cast<int>(std::floor(lo[1]))),
              v1 = std::min(size[v] - 1, static_cast<int>(hi[1]) + 1);
    for (int i = u0; i <= u1; ++i) {
      for (int j = v0; j <= v1; ++j) {
        const double pu = i + kShiftU, pv = j + kShiftV;
        double w[3];
        for (int k = 0; k < 3; ++k) {
          const glm::dvec3 &a = *corner[(k + 1) % 3], &b = *corner[(k + 2) % 3];
          w[k] = (b[u] - a[u]) * (pv - a[v]) - (b[v] - a[v]) * (pu - a[u]);
        }
        const bool left = w[0] > 0 && w[1] > 0 && w[2] > 0, right = w[0] < 0 && w[1] < 0 && w[2] < 0;
        if (!left && !right) continue;
        const double at = (w[0] * t.a[axis] + w[1] * t.b[axis] + w[2] * t.c[axis]) / (w[0] + w[1] + w[2]);
        found.push_back(
            {static_cast<std::uint32_t>(i) * static_cast<std::uint32_t>(size[v]) + static_cast<std::uint32_t>(j),
             {static_cast<float>(at), left ? 1 : -1}});
      }
    }
  }
  // Sorts the crossings by line, then along each line.
  Lines lines;
  const std::size_t count = static_cast<std::size_t>(size[u]) * static_cast<std::size_t>(size[v]);
  lines.first.assign(count + 1, 0);
  for (const OfLine& f : found) ++lines.first[f.line + 1];
  for (std::size_t k = 0; k < count; ++k) lines.first[k + 1] += lines.first[k];
  lines.crossings.resize(found.size());
  std::vector<std::uint32_t> next(lines.first.begin(), lines.first.end() - 1);
  for (const OfLine& f : found) lines.crossings[next[f.line]++] = f.crossing;
  for (std::size_t k = 0; k < count; ++k) {
    const auto from = lines.crossings.begin();
    std::sort(from + lines.first[k], from + lines.first[k + 1],
              [](const Crossing& a, const Crossing& b) { return a.at < b.at; });
  }
  return lines;
}

WindingNumbers::WindingNumbers(std::span<const Triangle> mesh, const glm::ivec3& size) : size_(size) {
  for_each_in_parallel(3, [&](int axis) { lines_[static_cast<std::size_t>(axis)] = lines_along(axis, mesh, size); });
}

std::span<const WindingNumbers::Crossing> WindingNumbers::line(int axis, int i, int j) const {
  const Lines& lines = lines_[static_cast<std::size_t>(axis)];
  const std::size_t k =
      static_cast<std::size_t>(i) * static_cast<std::size_t>(size_[(axis + 2) % 3]) + static_cast<std::size_t>(j);
  return {lines.crossings.data() + lines.first[k], lines.first[k + 1] - lines.first[k]};
}

std::vector<std::int16_t> WindingNumbers::slab(int x) const {
  const auto length = static_cast<std::size_t>(size_.z);
  std::vector<std::int16_t> sixths(static_cast<std::size_t>(size_.y) * length, 0);
  // Adds the crossings of a line for rays in both directions; for the negative direction, the signs are reversed.
  const auto add = [&](std::span<const Crossing> of_line, int k, std::int16_t& to) {
    for (const Crossing& c : of_line)
      to = static_cast<std::int16_t>(to + (c.at < static_cast<float>(k) ? -c.leaves : c.leaves));
  };
  for (int y = 0; y < size_.y; ++y) {
    const std::span<const Crossing> along_z = line(2, x, y);
    for (int z = 0; z < size_.z; ++z) {
      std::int16_t& to = sixths[static_cast<std::size_t>(y) * length + static_cast<std::size_t>(z)];
      add(line(0, y, z), x, to);
      add(along_z, z, to);
    }
  }
  for (int z = 0; z < size_.z; ++z) {
    const std::span<const Crossing> along_y = line(1, z, x);
    if (along_y.empty()) continue;
    for (int y = 0; y < size_.y; ++y)
      add(along_y, y, sixths[static_cast<std::size_t>(y) * length + static_cast<std::size_t>(z)]);
  }
  return sixths;
}

// Divides large triangles, because their bounding boxes are mostly empty.
static void mark_near(const Triangle& t, double reach, Grid<std::uint8_t>& near) {
  const glm::dvec3 lo = glm::min(t.a, glm::min(t.b, t.c)), hi = glm::max(t.a, glm::max(t.b, t.c));
  const glm::dvec3 extent = hi - lo;
  if (std::max({extent.x, extent.y, extent.z}) > BlockSet::kEdge) {
    const glm::dvec3 ab = 0.5 * (t.a + t.b), bc = 0.5 * (t.b + t.c), ca = 0.5 * (t.c + t.a);
    for (const Triangle& part : {Triangle{t.a, ab, ca}, {ab, t.b, bc}, {ca, bc, t.c}, {ab, bc, ca}})
      mark_near(part, reach, near);
    return;
  }
  const glm::ivec3 from = glm::max(glm::ivec3(glm::floor((lo - reach) / double{BlockSet::kEdge})), glm::ivec3(0)),
                   to = glm::min(glm::ivec3(glm::floor((hi + reach) / double{BlockSet::kEdge})), near.size - 1);
  for_each_voxel_between(from, to, [&](int x, int y, int z) { near(x, y, z) = 1; });
}

std::vector<std::uint8_t> blocks_near(std::span<const Triangle> mesh, const glm::ivec3& size, double reach) {
  Grid<std::uint8_t> near(BlockSet::blocks_of(size), 0);
  for (const Triangle& t : mesh) mark_near(t, reach, near);
  return near.v;
}

Sparse<float> unsigned_distance(std::span<const Triangle> mesh, const glm::ivec3& size, double band) {
  const double reach = band + 1.5;
  const auto set = std::make_shared<const BlockSet>(size, blocks_near(mesh, size, reach + 1));
  // Nearest triangle; -1: none within `band`.
  Sparse<std::int32_t> feature(set, -1, -1);
  Sparse<float> nearest(set, static_cast<float>(band), static_cast<float>(band));
  nearest.fill(std::numeric_limits<float>::max());
  const auto squared_from = [&](std::int32_t f) {
    return [&triangle = mesh[static_cast<std::size_t>(f)]](const glm::ivec3& i) {
      const glm::dvec3 p(i), off = p - nearest_on_triangle(triangle.a, triangle.b, triangle.c, p).p;
      return glm::dot(off, off);
    };
  };
  for (std::size_t f = 0; f < mesh.size(); ++f) {
    const Triangle& t = mesh[f];
    const auto squared = squared_from(static_cast<std::int32_t>(f));
    const glm::ivec3 lo = glm::max(glm::ivec3(glm::floor(glm::min(t.a, glm::min(t.b, t.c)))), glm::ivec3(0));
    const glm::ivec3 hi = glm::min(glm::ivec3(glm::ceil(glm::max(t.a, glm::max(t.b, t.c)))), size - 1);
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
      const std::ptrdiff_t at = number(feature, {x, y, z});
      if (at < 0) return;
      const auto d = static_cast<float>(std::sqrt(squared({x, y, z})));
      if (d < nearest.v[static_cast<std::size_t>(at)] && d < 2) {
        nearest.v[static_cast<std::size_t>(at)] = d;
        feature.v[static_cast<std::size_t>(at)] = static_cast<std::int32_t>(f);
      }
    });
  }
  propagate(feature, nearest, reach, 1, squared_from);
  for_each_sample(*set, [&](std::size_t i) { nearest.v[i] = std::min(nearest.v[i], static_cast<float>(band)); });
  return nearest;
}

}  // namespace typodont::haptics::importing
