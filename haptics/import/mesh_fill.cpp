#include "haptics/import/mesh_fill.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "engine/base/voxels.h"
#include "haptics/import/triangle_tree.h"

namespace typodont::haptics::importing {

namespace {

using glm::dvec3;

constexpr int kInside = 3;  // winding number in sixths, from which on a sample is inside

/// Outer surface of the parts: omits buried triangles, and splits partly buried ones down to the size of a voxel.
class Skin {
 public:
  Skin(std::span<const std::vector<Triangle>> parts, const Mask& part) : part_(part) {
    for (const auto& one : parts) mesh_.insert(mesh_.end(), one.begin(), one.end());
  }

  std::vector<Triangle> find() {
    std::vector<Triangle> skin;
    for (const Triangle& t : mesh_) {
      const std::size_t before = skin.size();
      if (add(t, skin)) {  // nothing was omitted: keeps the whole triangle
        skin.resize(before);
        skin.push_back(t);
      }
    }
    return skin;
  }

 private:
  /// Adds the outer parts of a triangle. Returns true if all of it is on the outer surface.
  bool add(const Triangle& t, std::vector<Triangle>& skin) {
    constexpr double kSmall = 2;  // voxels, smaller triangles are not split
    const dvec3* p[3] = {&t.a, &t.b, &t.c};
    int longest = 0;
    double length = 0;
    for (int k = 0; k < 3; ++k) {
      const double l = glm::length(*p[(k + 1) % 3] - *p[k]);
      if (l > length) length = l, longest = k;
    }
    if (length > kSmall) {
      const dvec3 &a = *p[longest], &b = *p[(longest + 1) % 3], &c = *p[(longest + 2) % 3];
      const dvec3 middle = 0.5 * (a + b);
      const bool one = add({a, middle, c}, skin), other = add({middle, b, c}, skin);
      return one && other;
    }
    if (is_buried(t)) return false;
    skin.push_back(t);
    return true;
  }

  bool is_buried(const Triangle& t) {
    const dvec3 normal = glm::cross(t.b - t.a, t.c - t.a);
    const double size = glm::length(normal);
    if (!(size > 0)) return false;
    // Test point near the centre; not exactly the centre, because the centres of opposite faces may coincide.
    const dvec3 at = 0.3371 * t.a + 0.3187 * t.b + 0.3442 * t.c, n = normal / size;
    // Distances of test points from the triangle, voxels. A side of the triangle is outside if the point at the
    // distance kAround is in no part. If the points of both sides are in one part, the winding numbers at kBeside
    // decide.
    constexpr double kAround = 1.5, kBeside = 1e-3;
    const auto part_at = [&](const dvec3& q) {
      const glm::ivec3 i(glm::round(q));
      return part_.holds(i) ? part_[i] : std::uint8_t{0};
    };
    const std::uint8_t one = part_at(at + kAround * n), other = part_at(at - kAround * n);
    if (one == 0 || other == 0) return false;
    // A triangle between two different parts is inside the body.
    if (one != other) return true;
    if (!tree_) tree_ = std::make_unique<TriangleTree>(mesh_);
    return tree_->winding_sixths(at + kBeside * n) >= kInside && tree_->winding_sixths(at - kBeside * n) >= kInside;
  }

  std::vector<Triangle> mesh_;
  const Mask& part_;
  std::unique_ptr<TriangleTree> tree_;  // created on first use
};

/// Fills cracks: if two parts are at most 3 voxels apart, samples between them join the part on the higher-index side.
void close_cracks(Mask& part) {
  const Mask before = part;
  constexpr int kReach = 2;
  for_each_voxel_in_parallel(part.size, [&](int x, int y, int z) {
    const glm::ivec3 p(x, y, z);
    for (int axis = 0; axis < 3 && !part[p]; ++axis) {
      std::uint8_t side[2] = {0, 0};
      int steps = 0;
      for (const int s : {0, 1}) {
        for (int k = 1; k <= kReach && !side[s]; ++k) {
          glm::ivec3 q = p;
          q[axis] += s ? k : -k;
          if (before.holds(q)) side[s] = before[q];
          ++steps;
        }
      }
      if (side[0] && side[1] && side[0] != side[1] && steps <= kReach + 1) part[p] = side[1];
    }
  });
}

/// Finds openings: pairs of neighbouring samples, one inside and one outside, without a triangle between them.
std::vector<glm::ivec3> find_cap(const Mask& part, const Sparse<float>& distance) {
  // Voxels. A triangle at most this far from one of the two samples counts as lying between them.
  constexpr float kOnMesh = 1;
  std::vector<std::vector<glm::ivec3>> found(static_cast<std::size_t>(part.size.x));
  for_each_voxel_in_parallel(part.size, [&](int x, int y, int z) {
    const glm::ivec3 p(x, y, z);
    for (int axis = 0; axis < 3; ++axis) {
      glm::ivec3 q = p;
      ++q[axis];
      if (!part.holds(q) || (part[q] != 0) == (part[p] != 0) || distance[p] <= kOnMesh || distance[q] <= kOnMesh)
        continue;
      found[static_cast<std::size_t>(x)].push_back(p);
      found[static_cast<std::size_t>(x)].push_back(q);
    }
  });
  std::vector<glm::ivec3> all;
  for (const auto& of_slab : found) all.insert(all.end(), of_slab.begin(), of_slab.end());
  return all;
}

/// Closes openings: reduces distances to those from `cap` (samples of find_cap()), and adds the blocks near `cap`.
void add_cap(const std::vector<glm::ivec3>& cap, double band, Sparse<float>& distance) {
  const BlockSet& before = *distance.set;
  const int reach = static_cast<int>(std::ceil(band)) + 1;
  Grid<std::uint8_t> wanted(before.count, 0);
  for (std::size_t b = 0; b < wanted.v.size(); ++b) wanted.v[b] = before.slot[b] >= 0;
  for (const glm::ivec3& p : cap) {
    const glm::ivec3 lo = glm::max(p - reach, glm::ivec3(0)) / BlockSet::kEdge,
                     hi = glm::min(p + reach, before.size - 1) / BlockSet::kEdge;
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) { wanted(x, y, z) = 1; });
  }
  const auto set = std::make_shared<const BlockSet>(before.size, wanted.v);
  SparseMask is_cap(set, 0, 0);
  for (const glm::ivec3& p : cap) is_cap.v[static_cast<std::size_t>(is_cap.index(p))] = 1;
  const Sparse<float> squared = distance_squared_to(is_cap, reach);
  Sparse<float> all(set, distance.outside, distance.inside);
  for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) {
    all.v[i] = static_cast<float>(
        std::min(static_cast<double>(distance[p]), std::sqrt(static_cast<double>(squared.v[i])) + 0.5));
  });
  distance = std::move(all);
}

}  // namespace

FilledMesh fill_mesh(std::span<const std::vector<Triangle>> parts, const glm::ivec3& size, double band) {
  FilledMesh filled;
  filled.part = Mask(size, 0);
  Mask& part = filled.part;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const WindingNumbers winding(parts[k], size);
    for_each_in_parallel(size.x, [&](int x) {
      const std::vector<std::int16_t> sixths = winding.slab(x);
      std::uint8_t* const slab = &part(x, 0, 0);
      for (std::size_t i = 0; i < sixths.size(); ++i) {
        if (sixths[i] >= kInside) slab[i] = static_cast<std::uint8_t>(k + 1);
      }
    });
  }
  if (parts.size() > 1) close_cracks(part);
  filled.distance = unsigned_distance(Skin(parts, part).find(), size, band);
  Sparse<float>& distance = filled.distance;

  filled.sheet = std::ranges::count(part.v, std::uint8_t{0}) + 8 > static_cast<std::ptrdiff_t>(part.v.size());
  if (!filled.sheet) {
    const std::vector<glm::ivec3> cap = find_cap(part, distance);
    filled.capped = !cap.empty();
    if (filled.capped) add_cap(cap, band, distance);
  }
  constexpr double kShell = 1;  // voxels, half the thickness of the solid that replaces a mesh without volume
  for_each_sample(*distance.set, [&](const glm::ivec3& p, std::size_t i) {
    double d = static_cast<double>(distance.v[i]);
    if (filled.sheet) d -= kShell;
    if (part[p] && !filled.sheet) d = -d;
    distance.v[i] = static_cast<float>(d);
  });
  // Blocks that are not stored lie completely inside or outside.
  const auto blocks = std::make_shared<BlockSet>(*distance.set);
  Grid<std::uint8_t> places;
  places.size = blocks->count;
  for (std::size_t b = 0; b < blocks->slot.size(); ++b) {
    if (blocks->slot[b] == BlockSet::kOutside && part[BlockSet::kEdge * places.place(b)] && !filled.sheet)
      blocks->slot[b] = BlockSet::kInside;
  }
  distance.set = blocks;
  distance.outside = static_cast<float>(filled.sheet ? band - kShell : band);
  distance.inside = static_cast<float>(-band);
  return filled;
}

void spread_parts(FilledMesh& filled, double reach) {
  Mask& part = filled.part;
  for (int pass = 0; pass < static_cast<int>(std::ceil(reach)); ++pass) {
    const Mask before = part;
    for_each_sample(*filled.distance.set, [&](const glm::ivec3& p, std::size_t i) {
      if (before[p] || filled.distance.v[i] > static_cast<float>(reach)) return;
      for (int k = 0; k < 27 && !part[p]; ++k) {
        const glm::ivec3 q = p + glm::ivec3(k % 3, k / 3 % 3, k / 9) - 1;
        if (before.holds(q)) part[p] = before[q];
      }
    });
  }
}

DenseTissue volume_around(const dvec3& lo, const dvec3& hi, double voxel, double band) {
  DenseTissue out;
  out.band = band;
  const double margin = band + 2 * voxel;
  out.frame.voxel = voxel;
  out.frame.origin = voxel * glm::floor((lo - margin) / voxel);
  out.size = glm::ivec3(glm::ceil((hi + margin - out.frame.origin) / voxel)) + 1;
  return out;
}

double memory_of_filling(std::span<const std::vector<Triangle>> parts, const glm::ivec3& size, double band) {
  // Memory per stored sample, per sample of the box, and per grid line; bytes.
  constexpr double kStored = 14, kPart = 1, kLine = 24;
  std::vector<Triangle> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  const std::vector<std::uint8_t> near = blocks_near(all, size, band + 2.5);
  const glm::dvec3 n(size);
  return kStored * static_cast<double>(std::ranges::count(near, std::uint8_t{1})) * BlockSet::kSamples +
         kPart * n.x * n.y * n.z + kLine * (n.x * n.y + n.y * n.z + n.z * n.x) +
         2 * static_cast<double>(all.size()) * sizeof(Triangle);
}

}  // namespace typodont::haptics::importing
