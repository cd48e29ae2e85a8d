#include "haptics/contact/mesh_lod/head_contact.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "haptics/contact/vertex/mesh_cutter.h"

namespace typodont::haptics::mesh_lod {

using vertex::FollowParameters;

namespace {

// m, tolerance: rounding can cause an overlap of this size for a head without contact
constexpr double kOverlap = 1e-9;
// Allowed overlap of a resting head with the tissue, as a ratio to the head's radius. Without it, a head with a sharp
// rim could never re-enter the hole that it has cut, because the hole has exactly the head's width.
constexpr double kSlack = 0.01;
constexpr double kLiftReach = 2e-3;  // m, distance within which a point inside the tissue searches for the surface

std::uint64_t hash_of(const dvec3& p) noexcept {
  std::uint64_t h = std::bit_cast<std::uint64_t>(p.x) * 0x9e3779b97f4a7c15U;
  h = (std::rotl(h, 23) ^ std::bit_cast<std::uint64_t>(p.y)) * 0xbf58476d1ce4e5b9U;
  h = (std::rotl(h, 29) ^ std::bit_cast<std::uint64_t>(p.z)) * 0x94d049bb133111ebU;
  return h;
}

}  // namespace

HeadContact::HeadContact(const Tool& tool) : head_(tool), slots_(std::size_t{1} << kSlotBits) {
  shares_.reserve(kMostPoints);
  near_.reserve(kMostPoints);
}

double HeadContact::moved_since_listing(const dvec3& c) const noexcept {
  return displacement_bound(points_.listed_at(), {c, R_WT_}, head_.reach());
}

void HeadContact::add(const dvec3& p, const dvec3& area, std::uint32_t face) noexcept {
  if (points_.add(p)) shares_.push_back({area, face});
}

/// Adds the corner p of a face to the contact points. `area`: area vector that belongs to the corner. Equal corners of
/// adjacent faces become one point with the sum of their areas.
void HeadContact::add_corner(const dvec3& p, const dvec3& area, std::uint32_t face) noexcept {
  std::size_t slot = hash_of(p) >> (64 - kSlotBits);
  for (; slots_[slot] != kFree; slot = (slot + 1) & (slots_.size() - 1)) {
    if (points_[slots_[slot]] != p) continue;
    shares_[slots_[slot]].area += area;
    return;
  }
  if (points_.full()) return;
  slots_[slot] = static_cast<std::uint32_t>(points_.size());
  add(p, area, face);
}

/// Lists the contact points near the head at c: those within the distance FollowParameters::margin (times the head's
/// radius). The distances of many points are computed together.
void HeadContact::list_around(const TriangleGrid& grid, const dvec3& c) noexcept {
  const double margin = FollowParameters::margin * head_.radius();
  const glm::dmat3 R_WT(glm::mat3_cast(R_WT_));
  const glm::vec3 axis(R_WT[2]);
  const dvec3 half = head_.half_box(R_WT[2]) + margin;
  points_.clear({c, R_WT_});
  shares_.clear();
  std::ranges::fill(slots_, kFree);
  // First finds the faces near the head, by the distances of their centres.
  near_.clear();
  distances_.clear();
  const auto list_found = [&] {
    distances_.evaluate(head_, R_WT, std::numeric_limits<double>::infinity());
    std::size_t kept = 0;
    for (std::size_t k = 0; k < distances_.size(); ++k) {
      const NearFace face = near_[distances_.point(k)];
      if (distances_.distance(k) <= margin + face.longest) near_[kept++] = face;
    }
    near_.resize(kept);
    list_points(grid, c, R_WT);
    near_.clear();
    distances_.clear();
  };
  grid.for_near(c - half, c + half, [&](std::uint32_t i) {
    if (!grid.box_within(i, c, outlook())) return;
    const Face& face = grid.face(i);
    const dvec3 sides[3] = {face.b - face.a, face.c - face.b, face.a - face.c};
    double longest2 = 0;
    for (const dvec3& side : sides) longest2 = std::max(longest2, glm::dot(side, side));
    const double longest = std::sqrt(longest2);
    const dvec3 middle = (face.a + face.b + face.c) / 3.0 - c;
    if (!head_.may_be_within(glm::vec3(middle), axis, static_cast<float>(margin + longest))) return;
    if (distances_.full()) list_found();
    distances_.add(static_cast<std::uint32_t>(near_.size()), middle);
    near_.push_back({i, longest});
  });
  list_found();
  distances_.keep_within(head_, points_, 0, std::numeric_limits<double>::infinity());
  listed_ = true;
}

/// Adds the corners of the faces in near_ to the contact points, and the additional points on large faces.
void HeadContact::list_points(const TriangleGrid& grid, const dvec3& c, const glm::dmat3& R_WT) noexcept {
  const double margin = FollowParameters::margin * head_.radius();
  const double spacing = vertex::CutParameters::longest * kSpacing * head_.radius();
  const glm::vec3 axis(R_WT[2]);
  const auto parts_of = [&](const NearFace& face) {
    return std::clamp(static_cast<int>(std::ceil(face.longest / spacing * (1 - 1e-9))), 1, kMostParts);
  };
  // Calls use(p, weight) for the additional points of a face that is divided into n² triangles. Each triangle gives a
  // third of its area to each of its three corners; `weight` is the number of these triangles at the point.
  const auto each_point = [&](const Face& face, int n, auto&& use) {
    for (int u = 0; u <= n; ++u) {
      for (int v = 0; v <= n - u; ++v) {
        const int w = n - u - v;
        if (u == n || v == n || w == n) continue;  // this point is a corner of the face itself
        const dvec3 p =
            (static_cast<double>(u) * face.a + static_cast<double>(v) * face.b + static_cast<double>(w) * face.c) /
            static_cast<double>(n);
        use(p, u == 0 || v == 0 || w == 0 ? 3.0 : 6.0);
      }
    }
  };
  const auto points_on = [](int n) { return static_cast<std::size_t>((n + 1) * (n + 2) / 2 - 3); };
  for (std::size_t first = 0, last = 0; first < near_.size(); first = last) {
    // Computes the distances of the additional points on as many faces as fit into the buffer.
    distances_.clear();
    std::uint32_t number = 0;
    for (last = first; last < near_.size(); ++last) {
      const int n = parts_of(near_[last]);
      if (last > first && distances_.size() + points_on(n) > distances_.most()) break;
      if (n == 1) continue;
      each_point(grid.face(near_[last].face), n, [&](const dvec3& p, double) {
        if (head_.may_be_within(glm::vec3(p - c), axis, static_cast<float>(margin))) distances_.add(number, p - c);
        ++number;
      });
    }
    distances_.evaluate(head_, R_WT, margin);
    std::size_t next = 0;
    number = 0;
    for (std::size_t k = first; k < last; ++k) {
      const std::uint32_t i = near_[k].face;
      const Face& face = grid.face(i);
      const int n = parts_of(near_[k]);
      const dvec3 share = face.normal() / (6.0 * n * n);
      for (int corner = 0; corner < 3; ++corner) add_corner(face.corner(corner), share, i);
      if (n == 1) continue;
      each_point(face, n, [&](const dvec3& p, double weight) {
        if (next < distances_.size() && distances_.point(next) == number) add(p, weight * share, i), ++next;
        ++number;
      });
    }
  }
}

void HeadContact::list_where_needed(const TriangleGrid& grid, const dvec3& c) noexcept {
  if (!listed_ || moved_since_listing(c) > FollowParameters::kept * head_.radius()) list_around(grid, c);
}

/// Returns the distance from the head at c to the nearest listed point, m.
double HeadContact::least_distance(const dvec3& c) noexcept {
  const glm::dmat3 R_TW = glm::transpose(glm::dmat3(glm::mat3_cast(R_WT_)));
  double least = FollowParameters::margin * head_.radius() - moved_since_listing(c);
  for (std::size_t i = 0; i < points_.size(); ++i) least = std::min(least, head_.distance(R_TW * (points_[i] - c)));
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
    if (!near.found) return false;  // the head is so deep inside the tissue that no surface is found; it does not move
    const dvec3 n = grid.face(near.face).normal();
    const double size = glm::length(n);
    c_ = near.p + head_.reach() * (size > 0 ? n / size : dvec3(0, 0, 1));
    listed_ = false;
    return false;
  }
  list_where_needed(grid, p);
  return least_distance(p) > -kSlack * head_.radius() - kOverlap;
}

void HeadContact::map_to(const TriangleGrid& grid) noexcept {
  listed_ = false;
  if (count_ == 0 && grid.inside(c_)) put(grid, c_);
}

void HeadContact::follow(const TriangleGrid& grid, const dvec3& hip, bool give) noexcept {
  c_ = follower_.follow(
      head_, points_, c_, {hip, R_WT_}, kSlack * head_.radius(), give,
      [&](const dvec3& p) { list_where_needed(grid, p); }, [](const dvec3&, double) {}, [] { return true; });
  leading_out_ = !points_.empty() && !give && follower_.led_out();
  count_ = 0;
  if (points_.empty()) return;
  for (int i = 0; i < follower_.count(); ++i) {
    const vertex::HeadFollower::Hold hold = follower_.hold(i);
    if (!(hold.push > 0)) continue;
    const Face& face = grid.face(shares_[hold.point].face);
    holds_[static_cast<std::size_t>(count_++)] = {points_[hold.point], hold.n, hold.push, face.tissue, false};
  }
}

double HeadContact::clearance(const TriangleGrid& grid, const dvec3& p, double most) noexcept {
  list_where_needed(grid, p);
  return std::min(most, least_distance(p));
}

PerTissue HeadContact::engaged_area(const TriangleGrid& grid, const dvec3& way) noexcept {
  PerTissue area{};
  const double within = kOnHead * head_.radius();
  distances_.find(head_, points_, {c_, R_WT_}, within);
  for (const std::uint32_t i : distances_.kept()) {
    const double across = -glm::dot(shares_[i].area, way);
    if (across > 0) area[static_cast<std::size_t>(grid.face(shares_[i].face).tissue)] += across;
  }
  return area;
}

}  // namespace typodont::haptics::mesh_lod
