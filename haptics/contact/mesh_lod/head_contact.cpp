#include "haptics/contact/mesh_lod/head_contact.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace typodont::haptics::mesh_lod {

namespace {

// m; a smaller overlap of head and tissue counts as rounding error
constexpr double kOverlap = 1e-9;
// Tolerated overlap of a head at rest with tissue, divided by the head's radius. Without it, a head with a sharp rim
// could not enter its own hole again, because the hole is as wide as the head.
constexpr double kAllowedDepth = 0.01;
// The next list of contact points is begun when the head has moved by this fraction of HeadPoints::kept.
constexpr double kAhead = 0.4;
// largest number of faces and points that are examined per tick for the next list of contact points
constexpr int kMaxListed = 600;
constexpr double kLiftReach = 2e-3;  // m, distance within which a head inside tissue searches the surface

}  // namespace

double HeadContact::moved_since(const HeadPoints& list, const dvec3& c) const noexcept {
  return displacement_bound(list.points.listed_at(), {c, R_WT_}, head_.reach());
}

/// Makes list_, the contact points near the head, valid for a head with its centre at c.
void HeadContact::list_where_needed(const TriangleGrid& grid, const dvec3& c) noexcept {
  if (HeadPoints* const prepared = std::exchange(prepared_, nullptr);
      prepared && moved_since(*prepared, c) <= prepared->kept) {
    std::swap(list_, *prepared);
    lister_.cancel();
    listed_ = true;
  }
  if (listed_ && moved_since(list_, c) <= list_.kept) return;
  if (lister_.open() && moved_since(next_, c) <= next_.kept) {
    lister_.work(grid, head_, next_);
    std::swap(list_, next_);
  } else {
    lister_.begin(grid, head_, {c, R_WT_}, margin(), kept(), list_);
    lister_.work(grid, head_, list_);
  }
  listed_ = true;
}

/// Makes one part of the next list of contact points per tick, so that the list is complete before it is needed.
void HeadContact::list_ahead(const TriangleGrid& grid) noexcept {
  if (!listed_ || list_.points.empty()) return;
  if (!lister_.open()) {
    if (moved_since(list_, c_) > kAhead * list_.kept) {
      lister_.begin(grid, head_, {c_, R_WT_}, margin(), kept(), next_);
    }
    return;
  }
  if (lister_.work(grid, head_, next_, kMaxListed) && moved_since(next_, c_) <= next_.kept) std::swap(list_, next_);
}

/// Smallest distance of a contact point from a head with its centre at c, m; negative: overlap.
double HeadContact::min_distance(const dvec3& c) noexcept {
  const glm::dmat3 R_TW = glm::transpose(glm::dmat3(glm::mat3_cast(R_WT_)));
  double least = list_.margin - moved_since(list_, c);
  const mesh::NearPoints& points = list_.points;
  for (std::size_t i = 0; i < points.size(); ++i) least = std::min(least, head_.distance(R_TW * (points[i] - c)));
  return least;
}

void HeadContact::put_free(const dvec3& p) noexcept {
  c_ = p;
  count_ = 0;
}

bool HeadContact::put(const TriangleGrid& grid, const dvec3& p) noexcept {
  put_free(p);
  if (grid.inside(p)) {
    const TriangleGrid::Nearest near = grid.nearest(p, kLiftReach);
    if (!near.found) return false;  // too deep to find a surface: the head stays here
    const dvec3 n = grid.face(near.face).normal();
    const double size = glm::length(n);
    c_ = near.p + head_.reach() * (size > 0 ? n / size : dvec3(0, 0, 1));
    listed_ = false;
    return false;
  }
  list_where_needed(grid, p);
  return min_distance(p) > -kAllowedDepth * head_.radius() - kOverlap;
}

void HeadContact::map_to(const TriangleGrid& grid) noexcept {
  listed_ = false;
  if (count_ == 0 && grid.inside(c_)) put(grid, c_);
}

void HeadContact::follow(const TriangleGrid& grid, const dvec3& hip, bool give) noexcept {
  c_ = follower_.follow(
      head_, list_.points, c_, {hip, R_WT_}, kAllowedDepth * head_.radius(), give,
      [&](const dvec3& p) { list_where_needed(grid, p); }, [](const dvec3&, double far) { return far; },
      [] { return true; });
  gives_ = give;
  leading_out_ = !list_.points.empty() && !give && follower_.led_out();
  count_ = 0;
  if (list_.points.empty()) return;
  for (int i = 0; i < follower_.count(); ++i) {
    const vertex::HeadFollower::Hold hold = follower_.hold(i);
    if (!(hold.push > 0)) continue;
    holds_[static_cast<std::size_t>(count_++)] = {list_.points[hold.point], hold.n, hold.push,
                                                  list_.areas[hold.point].tissue, false};
  }
  list_ahead(grid);
}

int HeadContact::near_planes(std::span<NearPlane, kMaxNearPlanes> planes) noexcept {
  if (!listed_ || list_.points.empty()) return 0;
  distances_.find(head_, list_.points, {c_, R_WT_}, margin());
  const std::span found(nearest_.data(), distances_.size());
  const std::size_t count = std::min(found.size(), planes.size());
  std::iota(found.begin(), found.end(), 0u);
  std::nth_element(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count), found.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return distances_.distance(a) < distances_.distance(b); });
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t i = found[k];
    planes[k] = {list_.points[distances_.point(i)] - c_, -distances_.normal_W(i),
                 vertex::allowed_motion(distances_.distance(i), kAllowedDepth * head_.radius(), gives_)};
  }
  return static_cast<int>(count);
}

double HeadContact::clearance(const TriangleGrid& grid, const dvec3& p, double most) noexcept {
  list_where_needed(grid, p);
  return std::min(most, min_distance(p));
}

PerTissue HeadContact::engaged_area(const TriangleGrid&, const dvec3& direction) noexcept {
  PerTissue area{};
  const double within = kOnHead * head_.radius();
  distances_.find(head_, list_.points, {c_, R_WT_}, within);
  for (const std::uint32_t i : distances_.kept()) {
    const HeadPoints::PointArea& point_area = list_.areas[i];
    const double across = -glm::dot(point_area.area, direction);
    if (across > 0) area[static_cast<std::size_t>(point_area.tissue)] += across;
  }
  return area;
}

}  // namespace typodont::haptics::mesh_lod
