#include "engine/app/task/crown_ideal.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "engine/base/in_parallel.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"

namespace typodont {

namespace {

// A surface belongs to the chewing surface if the cosine between normal and axis exceeds this.
constexpr double kOcclusal = 0.5;
// Cell size of the grid for the margin's outline, m.
constexpr double kCell = 0.1e-3;
// Half the distance over which normals are computed, voxels. Over a shorter distance, noise of the CT would change
// them.
constexpr double kNormalReach = 2;
// Distances are exact up to this value, voxels.
constexpr double kExactBand = 3;
// m; tissue this far below the margin stays. Larger than all distances that a volume stores.
constexpr double kBelowMargin = 2.5e-3;

/// Outline of the tooth at the height of the margin, with a signed distance.
class Outline {
 public:
  Outline(const DenseCopy& copy, const session::DenseField& tooth, const glm::dmat3& axes, double height) {
    glm::dvec2 lo(1e9), hi(-1e9);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::ivec3 n = copy.field.size - 1;
      const dvec3 p = glm::transpose(axes) *
                      copy.frame.to_world(dvec3(corner & 1 ? n.x : 0, corner & 2 ? n.y : 0, corner & 4 ? n.z : 0));
      lo = glm::min(lo, glm::dvec2(p)), hi = glm::max(hi, glm::dvec2(p));
    }
    const glm::ivec2 n = glm::ivec2((hi - lo) / kCell) + 1;
    const auto place = [&](int i, int j) { return lo + kCell * glm::dvec2(i, j); };
    inside_ = [&copy, &tooth, &axes, height](const glm::dvec2& q) {
      return tooth.sample(copy.frame.to_voxels(axes * dvec3(q, height)));
    };
    for (int i = 0; i + 1 < n.x; ++i) {
      for (int j = 0; j + 1 < n.y; ++j) {
        const glm::dvec2 p = place(i, j);
        const double at = inside_(p);
        for (const glm::dvec2& q : {place(i + 1, j), place(i, j + 1)}) {
          const double next = inside_(q);
          if ((at < 0) != (next < 0)) points_.push_back(p + at / (at - next) * (q - p));
        }
      }
    }
  }
  bool empty() const { return points_.empty(); }
  /// Signed distance to the plane outline, negative inside, m.
  double distance(const glm::dvec2& q) const {
    double square = 1e18;  // m², squared distance to the nearest point
    for (const glm::dvec2& p : points_) square = std::min(square, glm::dot(p - q, p - q));
    return inside_(q) < 0 ? -std::sqrt(square) : std::sqrt(square);
  }

 private:
  std::vector<glm::dvec2> points_;
  std::function<double(const glm::dvec2&)> inside_;
};

/// Returns perpendicular unit vectors u, v, w as the columns of a matrix; w is `axis`.
glm::dmat3 basis(const dvec3& axis) {
  const dvec3 least = std::abs(axis.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 v = glm::normalize(glm::cross(axis, least));
  return {glm::cross(v, axis), v, axis};
}

/// Distance from the region in which the centre of the bur's round end may be (outside of the wall, above the chamfer),
/// m. `aside`: distance from the outline at the margin, m. `height`: height along the axis, m.
double from_centers(const CrownReduction& crown, double aside, double height) {
  const double lean = 0.5 * crown.taper, bottom = crown.margin_height + crown.chamfer_radius;
  // Distance from the wall, m.
  const double wall = (aside + crown.chamfer + (height - crown.margin_height) * std::tan(lean)) * std::cos(lean);
  const double inside = std::max(0.0, crown.chamfer_radius - wall), below = std::max(0.0, bottom - height);
  if (height + inside * std::sin(lean) >= bottom) return inside;
  const double corner = crown.chamfer_radius / std::cos(lean) - crown.chamfer - crown.chamfer_radius * std::tan(lean);
  return aside < corner ? std::hypot(aside - corner, below) : below;
}

/// Calls what(x) for each x of the grid, on several threads.
template <class What>
void each_slice(const glm::ivec3& size, const What& what) {
  in_parallel(
      static_cast<std::size_t>(size.x), [&](std::size_t x) { what(static_cast<int>(x)); }, {}, /*block=*/4);
}

/// Removes the tissue less than `depth` (m) below those surface points for which wanted(point in W, normal) is true.
/// `gone`: for each voxel, the largest value of depth minus distance, m.
template <class Wanted>
void reduce_below(const DenseCopy& copy, const session::DenseField& tooth, double depth, const Wanted& wanted,
                  std::vector<float>& gone) {
  const glm::ivec3 n = tooth.size;
  const double h = copy.frame.voxel, reach = depth / h + kExactBand;
  std::vector<double> nearest(gone.size(), std::numeric_limits<double>::infinity());  // distance² to surface, voxels²
  std::vector<std::vector<dvec3>> points(static_cast<std::size_t>(n.x));  // of the surface, beside voxels at each x
  const auto add_point = [&](int x, int y, int z) {
    const double d = static_cast<double>(tooth.distance[tooth.at(x, y, z)]);
    if (std::abs(d) > 1) return;
    const dvec3 p(x, y, z), g = tooth.gradient(p, kNormalReach);
    if (glm::length(g) < 0.1) return;
    const dvec3 normal = glm::normalize(g), q = p - d * normal;
    if (wanted(copy.frame.to_world(q), normal)) points[static_cast<std::size_t>(x)].push_back(q);
  };
  const auto take_nearest = [&](int i, const dvec3& q) {
    if (std::abs(i - q.x) > reach) return;
    const glm::ivec3 lo = glm::max(glm::ivec3(glm::ceil(q - reach)), glm::ivec3(0)),
                     hi = glm::min(glm::ivec3(glm::floor(q + reach)), n - 1);
    for (int j = lo.y; j <= hi.y; ++j) {
      const double aside = (i - q.x) * (i - q.x) + (j - q.y) * (j - q.y);
      double* const row = &nearest[tooth.at(i, j, 0)];
      for (int k = lo.z; k <= hi.z; ++k) row[k] = std::min(row[k], aside + (k - q.z) * (k - q.z));
    }
  };
  each_slice(n, [&](int x) { for_each_voxel_between({x, 0, 0}, {x, n.y - 1, n.z - 1}, add_point); });
  each_slice(n, [&](int x) {
    const int around = static_cast<int>(reach) + 2;
    for (int from = std::max(x - around, 0); from <= std::min(x + around, n.x - 1); ++from)
      for (const dvec3& q : points[static_cast<std::size_t>(from)]) take_nearest(x, q);
  });
  for (std::size_t i = 0; i < gone.size(); ++i)
    gone[i] = std::max(gone[i], static_cast<float>(depth - h * std::sqrt(nearest[i])));
}

/// Distances in a box.
struct Part {
  glm::ivec3 lo;  // its first voxel
  DenseCopy copy;
};
/// The part of `copy` that encloses the voxels above the height `least` (m) along `axis`; nothing if there are none.
std::optional<Part> part_above(const DenseCopy& copy, const dvec3& axis, double least) {
  glm::ivec3 lo(copy.field.size), hi(-1);
  for_each_voxel(copy.field.size, [&](const glm::ivec3& p) {
    if (glm::dot(copy.frame.to_world(dvec3(p)), axis) > least) lo = glm::min(lo, p), hi = glm::max(hi, p);
  });
  if (hi.x < 0) return std::nullopt;
  Part part{lo, {}};
  part.copy.frame = {copy.frame.to_world(dvec3(lo)), copy.frame.voxel};
  part.copy.field.size = hi - lo + 1;
  std::vector<float>& distance = part.copy.field.distance;
  for (int x = lo.x; x <= hi.x; ++x) {
    for (int y = lo.y; y <= hi.y; ++y) {
      const auto row = copy.field.distance.begin() + static_cast<std::ptrdiff_t>(copy.field.at(x, y, lo.z));
      distance.insert(distance.end(), row, row + part.copy.field.size.z);
    }
  }
  return part;
}

/// Moves the surface outwards by `by` voxels; a negative value moves it inwards.
session::DenseField moved(session::DenseField field, double by) {
  for (float& d : field.distance) d -= static_cast<float>(by);
  return session::redistanced(field);
}

}  // namespace

void reduce_for_crown(const CrownReduction& crown, const dvec3& axis_W, DenseCopy& copy) {
  const auto part = part_above(copy, axis_W, crown.margin_height - kBelowMargin);
  if (!part) return;
  const DenseCopy& top = part->copy;
  const double h = top.frame.voxel;
  const glm::ivec3 n = top.field.size;
  const glm::dmat3 axes = basis(axis_W);
  const session::DenseField tooth = session::redistanced(top.field);
  const Outline outline(top, tooth, axes, crown.margin_height);
  if (outline.empty()) return;

  // Removes a layer of depth `chamfer` above the chamfer, and one of depth `occlusal` at the chewing surface.
  std::vector<float> gone(top.field.distance.size(), static_cast<float>(-kExactBand * h));
  const auto above = [&](const dvec3& p_W, double height) { return glm::dot(p_W, axis_W) > height; };
  const double over_chamfer = crown.margin_height + crown.chamfer_radius;
  reduce_below(
      top, tooth, crown.chamfer, [&](const dvec3& p_W, const dvec3&) { return above(p_W, over_chamfer); }, gone);
  reduce_below(
      top, tooth, crown.occlusal,
      [&](const dvec3& p_W, const dvec3& normal) {
        return above(p_W, over_chamfer + crown.occlusal) && glm::dot(normal, axis_W) > kOcclusal;
      },
      gone);
  session::DenseField kept{n, std::vector<float>(gone.size())};
  in_parallel(static_cast<std::size_t>(n.x), [&](std::size_t x) {
    glm::dvec2 at(1e9);
    double aside = 0;  // m, the outline's distance at `at`
    for (int y = 0; y < n.y; ++y) {
      for (int z = 0; z < n.z; ++z) {
        const std::size_t i = kept.at(static_cast<int>(x), y, z);
        const dvec3 p = glm::transpose(axes) * top.frame.to_world(dvec3(x, y, z));
        if (glm::dvec2(p) != at) at = p, aside = outline.distance(at);
        const double wall = crown.chamfer_radius - from_centers(crown, aside, p.z);
        kept.distance[i] = static_cast<float>(std::max(static_cast<double>(gone[i]), wall) / h);
      }
    }
  });
  // Rounds edges: moves the surface inwards by `radius`, then outwards.
  const double radius = crown.edge_radius / h;
  if (radius > 0) kept = moved(moved(session::redistanced(kept), -radius), radius);
  for_each_voxel(n, [&](int x, int y, int z) {
    const glm::ivec3 at = part->lo + glm::ivec3(x, y, z);
    float& d = copy.field.distance[copy.field.at(at.x, at.y, at.z)];
    d = std::max(d, kept.distance[kept.at(x, y, z)]);
  });
}

}  // namespace typodont
