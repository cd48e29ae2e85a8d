// Samples the surface at rest from a distance function: one point in each lattice cell that the surface crosses
// (surface nets, Gibson 1998, "Constrained elastic surface nets").
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "haptics/soft_tissue.h"

namespace typodont::haptics {

namespace {

constexpr double kCell = 1e-3;  // m, edge of the cells of the search grid
// Smallest thickness used for a layer, m.
constexpr double kMinThickness = 0.2e-3;
// Depth of the layer that is sheared divided by its thickness. With one third, the stiffness under a ball of 1.2 mm
// lies between that of Hertz (deep layer) and that of a thin layer.
constexpr double kSheared = 1.0 / 3;
constexpr std::size_t kMaxCells = 1u << 24;

/// A regular grid of samples of the distance function.
struct Lattice {
  dvec3 lo;
  double step;
  glm::ivec3 size;  // number of samples along each axis
  std::size_t index(const glm::ivec3& i) const { return voxel_index(i, size); }
  dvec3 at(const glm::ivec3& i) const { return lo + step * dvec3(i); }
};

dvec3 gradient_at(const std::function<double(const dvec3&)>& distance, const dvec3& p, double step) {
  dvec3 slope;
  for (int axis = 0; axis < 3; ++axis) {
    dvec3 along(0);
    along[axis] = step;
    slope[axis] = (distance(p + along) - distance(p - along)) / (2 * step);
  }
  return slope;
}

}  // namespace

SoftSurface::SoftSurface(const SoftLaw& law, const dvec3& lo, const dvec3& hi,
                         const std::function<double(const dvec3&)>& distance,
                         const std::function<bool(const dvec3&)>& hidden)
    : law_(law), lo_(lo) {
  const Lattice lattice{lo, law.spacing, glm::ivec3(glm::ceil((hi - lo) / law.spacing)) + 1};
  const dvec3 size(lattice.size);
  if (!(size.x * size.y * size.z < static_cast<double>(kMaxCells)))
    throw std::invalid_argument("soft surface too large");
  std::vector<float> sample;
  sample.reserve(voxel_count(lattice.size));
  for_each_voxel(lattice.size,
                 [&](const glm::ivec3& i) { sample.push_back(static_cast<float>(distance(lattice.at(i)))); });

  // For each lattice cell: index of its point (mean of the crossings on the cell's edges, moved onto the surface).
  std::vector<std::int32_t> point_of(sample.size(), -1);
  for_each_voxel(lattice.size - 1, [&](const glm::ivec3& i) {
    dvec3 sum(0);
    int crossings = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (int corner = 0; corner < 4; ++corner) {
        glm::ivec3 a = i;
        a[(axis + 1) % 3] += corner & 1, a[(axis + 2) % 3] += corner >> 1;
        glm::ivec3 b = a;
        ++b[axis];
        const double da = sample[lattice.index(a)], db = sample[lattice.index(b)];
        if ((da < 0) == (db < 0)) continue;
        sum += glm::mix(lattice.at(a), lattice.at(b), da / (da - db));
        ++crossings;
      }
    if (crossings == 0) return;
    Point point;
    point.p_W = sum / static_cast<double>(crossings);
    const dvec3 slope = gradient_at(distance, point.p_W, 0.25 * law.spacing);
    const double steep = glm::length(slope);
    if (!(steep > 1e-3)) return;
    point.n_W = slope / steep;
    const double off = std::clamp(distance(point.p_W) / steep, -law.spacing / 2, law.spacing / 2);
    point.p_W -= off * point.n_W;
    if (hidden(point.p_W)) return;
    // Step of the search along the normal for the end of the soft layer, m.
    const double step = 0.1e-3;
    double deep = step;
    while (deep < law.thickness && distance(point.p_W - deep * point.n_W) < 0 &&
           !hidden(point.p_W - deep * point.n_W)) {
      deep += step;
    }
    point.thickness = std::clamp(deep, kMinThickness, std::max(law.thickness, kMinThickness));
    point_of[lattice.index(i)] = static_cast<std::int32_t>(points_.size());
    points_.push_back(point);
  });

  // The points around a crossed lattice edge form a quad. Each point gets a fourth of its area, each side a link with
  // tension T = G d / 3 (N/m), G = E / 3; d: sheared depth (Pasternak).
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> tension;
  for_each_voxel_between(glm::ivec3(1), lattice.size - 2, [&](const glm::ivec3& i) {
    for (int axis = 0; axis < 3; ++axis) {
      glm::ivec3 next = i;
      ++next[axis];
      if ((sample[lattice.index(i)] < 0) == (sample[lattice.index(next)] < 0)) continue;
      glm::ivec3 u(0), v(0);
      u[(axis + 1) % 3] = 1, v[(axis + 2) % 3] = 1;
      const std::int32_t corner[4] = {point_of[lattice.index(i)], point_of[lattice.index(i - u)],
                                      point_of[lattice.index(i - u - v)], point_of[lattice.index(i - v)]};
      if (std::min({corner[0], corner[1], corner[2], corner[3]}) < 0) continue;
      const auto p = [&](int k) { return points_[static_cast<std::size_t>(corner[k])].p_W; };
      const double area = glm::length(glm::cross(p(2) - p(0), p(3) - p(1))) / 2;
      for (int k = 0; k < 4; ++k) {
        const auto a = static_cast<std::uint32_t>(corner[k]), b = static_cast<std::uint32_t>(corner[(k + 1) % 4]);
        points_[a].area += area / 4;
        const double length = glm::length(p(k) - p((k + 1) % 4));
        if (!(length > 0.05 * law.spacing)) continue;
        const double h = (points_[a].thickness + points_[b].thickness) / 2;
        tension[std::minmax(a, b)] += law.elastic_modulus / 3 * kSheared * h / 3 * area / (2 * length * length);
      }
    }
  });
  // Smallest area of a point, m²; smaller areas, which occur at the edge of the box, are increased to this.
  const double min_area = 0.1 * law.spacing * law.spacing;
  for (Point& point : points_) point.area = std::max(point.area, min_area);

  std::vector<std::vector<Link>> links(points_.size());
  for (const auto& [pair, t] : tension) {
    links[pair.first].push_back({pair.second, t});
    links[pair.second].push_back({pair.first, t});
  }
  first_link_.push_back(0);
  for (const std::vector<Link>& of_point : links) {
    links_.insert(links_.end(), of_point.begin(), of_point.end());
    first_link_.push_back(static_cast<std::uint32_t>(links_.size()));
  }
  cells_ = glm::max(glm::ivec3(glm::ceil((hi - lo) / kCell)), glm::ivec3(1));
  build_cells();
}

void SoftSurface::build_cells() {
  const std::size_t count = voxel_count(cells_);
  cell_first_.assign(count + 1, 0);
  for (const Point& point : points_) ++cell_first_[cell_index(cell_of(point.p_W)) + 1];
  for (std::size_t c = 0; c < count; ++c) cell_first_[c + 1] += cell_first_[c];
  cell_points_.resize(points_.size());
  std::vector<std::uint32_t> next(cell_first_.begin(), cell_first_.end() - 1);
  for (std::uint32_t p = 0; p < points_.size(); ++p) cell_points_[next[cell_index(cell_of(points_[p].p_W))]++] = p;

  // Lists the cells with points. The number of cells to the nearest of them gives a lower bound of the distance.
  std::vector<glm::ivec3> occupied;
  for_each_voxel(cells_, [&](const glm::ivec3& c) {
    if (cell_first_[cell_index(c)] < cell_first_[cell_index(c) + 1]) occupied.push_back(c);
  });
  cell_clearance_.assign(count, std::numeric_limits<float>::max());
  if (occupied.empty()) return;
  for_each_voxel(cells_, [&](const glm::ivec3& c) {
    int nearest = std::numeric_limits<int>::max();
    for (const glm::ivec3& o : occupied) {
      // number of whole cells between the cells o and c, along each axis
      const glm::ivec3 gap = glm::max(glm::abs(o - c) - 1, glm::ivec3(0));
      nearest = std::min(nearest, gap.x * gap.x + gap.y * gap.y + gap.z * gap.z);
    }
    cell_clearance_[cell_index(c)] = static_cast<float>(kCell * std::sqrt(static_cast<double>(nearest)));
  });
}

glm::ivec3 SoftSurface::cell_of(const dvec3& p_W) const noexcept {
  const dvec3 at = glm::clamp((p_W - lo_) / kCell, dvec3(0), dvec3(cells_) - 0.5);
  return glm::ivec3(at);
}

double SoftSurface::clearance(const dvec3& p_W) const noexcept {
  if (points_.empty()) return std::numeric_limits<double>::max();
  const dvec3 hi = lo_ + kCell * dvec3(cells_);
  const dvec3 off = glm::max(glm::max(lo_ - p_W, p_W - hi), dvec3(0));
  return std::max(glm::length(off), static_cast<double>(cell_clearance_[cell_index(cell_of(p_W))]) - glm::length(off));
}

}  // namespace typodont::haptics
