#include "haptics/import/mesh_fill.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "haptics/import/triangle_tree.h"

namespace typodont::haptics::importing {

namespace {

using glm::dvec3;

constexpr int kInside = 3;  // a sample is inside if its winding number, multiplied by six, is at least this

/// Collects the triangles that form the outer surface of the body. Triangles completely within the body, where parts of
/// the mesh overlap or touch, are omitted. Triangles partly within the body are split, down to a size of about one
/// voxel.
class Skin {
 public:
  Skin(std::span<const std::vector<Triangle>> parts, const Mask& part) : part_(part) {
    for (const auto& one : parts) mesh_.insert(mesh_.end(), one.begin(), one.end());
  }

  std::vector<Triangle> find() {
    std::vector<Triangle> skin;
    for (const Triangle& t : mesh_) {
      const std::size_t before = skin.size();
      if (add(t, skin)) {  // if no part of the triangle was omitted, the whole triangle is added
        skin.resize(before);
        skin.push_back(t);
      }
    }
    return skin;
  }

 private:
  /// Adds those parts of a triangle that belong to the outer surface. Returns true if this is the whole triangle.
  bool add(const Triangle& t, std::vector<Triangle>& skin) {
    constexpr double kSmall = 2;  // voxels; a triangle whose longest edge is at most this long is not split
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
    // The test point is not the triangle's centre, because the centres of opposite faces can coincide on a diagonal.
    const dvec3 at = 0.3371 * t.a + 0.3187 * t.b + 0.3442 * t.c, n = normal / size;
    // A triangle belongs to the outer surface if at least one of its two sides lies outside the body. First, the
    // samples at the distance kAround on both sides are tested, because their winding numbers are already known. If
    // both lie in the same part, the winding numbers at the distance kBeside on both sides are computed. Both distances
    // are in voxels.
    constexpr double kAround = 1.5, kBeside = 1e-3;
    const auto part_at = [&](const dvec3& q) {
      const glm::ivec3 i(glm::round(q));
      return part_.holds(i) ? part_[i] : std::uint8_t{0};
    };
    const std::uint8_t one = part_at(at + kAround * n), other = part_at(at - kAround * n);
    if (one == 0 || other == 0) return false;
    // The two samples lie in different parts of the mesh. The triangle is buried between these
    // parts.
    if (one != other) return true;
    if (!tree_) tree_ = std::make_unique<TriangleTree>(mesh_);
    return tree_->winding_sixths(at + kBeside * n) >= kInside && tree_->winding_sixths(at - kBeside * n) >= kInside;
  }

  std::vector<Triangle> mesh_;
  const Mask& part_;
  std::unique_ptr<TriangleTree> tree_;  // created on first use
};

/// Closes cracks. A sample is in a crack if it lies outside, on a grid line between two different parts that are at
/// most three voxels apart. The sample is then added to one of the two parts, the one with the larger coordinate on
/// this line.
void close_cracks(Mask& part) {
  const Mask before = part;
  constexpr int kReach = 2;
  for (std::size_t i = 0; i < part.v.size(); ++i) {
    if (before.v[i]) continue;
    const glm::ivec3 p = part.place(i);
    for (int axis = 0; axis < 3 && !part.v[i]; ++axis) {
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
      if (side[0] && side[1] && side[0] != side[1] && steps <= kReach + 1) part.v[i] = side[1];
    }
  }
}

}  // namespace

FilledMesh fill_mesh(std::span<const std::vector<Triangle>> parts, const glm::ivec3& size, double band) {
  FilledMesh filled;
  filled.part = Mask(size, 0);
  Mask& part = filled.part;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Grid<std::int16_t> sixths = winding_sixths(parts[k], size);
    for (std::size_t i = 0; i < part.v.size(); ++i) {
      if (sixths.v[i] >= kInside) part.v[i] = static_cast<std::uint8_t>(k + 1);
    }
  }
  if (parts.size() > 1) close_cracks(part);
  const auto inside = [&](std::size_t i) { return part.v[i] != 0; };
  filled.distance = unsigned_distance(Skin(parts, part).find(), size, band);
  Grid<float>& distance = filled.distance;

  filled.sheet = std::ranges::count(part.v, std::uint8_t{0}) + 8 > static_cast<std::ptrdiff_t>(part.v.size());
  // Marks the samples where inside and outside meet although no triangle is near. There the mesh has an opening, which
  // is closed by a cap.
  Mask cap(size, 0);
  if (!filled.sheet) {
    // voxels; if a sample is nearer to the mesh than this, there is a triangle beside it, and no opening
    constexpr float kOnMesh = 1;
    const glm::ivec3 steps[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (std::size_t i = 0; i < distance.v.size(); ++i) {
      if (distance.v[i] <= kOnMesh) continue;
      const glm::ivec3 p = distance.place(i);
      for (const glm::ivec3& step : steps) {
        if (!distance.holds(p + step)) continue;
        const std::size_t j = distance.index(p + step);
        if (distance.v[j] <= kOnMesh || inside(i) == inside(j)) continue;
        cap.v[i] = cap.v[j] = 1;
        filled.capped = true;
      }
    }
  }
  const Grid<float> to_cap = filled.capped ? distance_squared_to(cap) : Grid<float>();
  constexpr double kShell = 1;  // voxels, half of the thickness that a sheet (a mesh without volume) gets
  for (std::size_t i = 0; i < distance.v.size(); ++i) {
    double d = static_cast<double>(distance.v[i]);
    if (filled.capped) d = std::min(d, std::sqrt(static_cast<double>(to_cap.v[i])) + 0.5);
    if (filled.sheet) d -= kShell;
    if (inside(i) && !filled.sheet) d = -d;
    distance.v[i] = static_cast<float>(d);
  }
  return filled;
}

void spread_parts(FilledMesh& filled, double reach) {
  for (int pass = 0; pass < static_cast<int>(std::ceil(reach)); ++pass) {
    const Mask before = filled.part;
    for (std::size_t i = 0; i < before.v.size(); ++i) {
      if (before.v[i] || filled.distance.v[i] > static_cast<float>(reach)) continue;
      const glm::ivec3 p = before.place(i);
      for (int k = 0; k < 27 && !filled.part.v[i]; ++k) {
        const glm::ivec3 q = p + glm::ivec3(k % 3, k / 3 % 3, k / 9) - 1;
        if (before.holds(q)) filled.part.v[i] = before[q];
      }
    }
  }
}

}  // namespace typodont::haptics::importing
