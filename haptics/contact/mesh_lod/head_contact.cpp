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
/// radius).
void HeadContact::list_around(const TriangleGrid& grid, const dvec3& c) noexcept {
  const double margin = FollowParameters::margin * head_.radius();
  const double spacing = vertex::CutParameters::longest * kSpacing * head_.radius();
  const glm::dmat3 R_WT(glm::mat3_cast(R_WT_)), R_TW = glm::transpose(R_WT);
  const glm::vec3 axis(R_WT[2]);
  const dvec3 half = head_.half_box(R_WT[2]) + margin;
  points_.clear({c, R_WT_});
  shares_.clear();
  std::ranges::fill(slots_, kFree);
  grid.for_near(c - half, c + half, [&](std::uint32_t i) {
    if (!grid.box_within(i, c, outlook())) return;
    const Face& face = grid.face(i);
    const dvec3 sides[3] = {face.b - face.a, face.c - face.b, face.a - face.c};
    double longest2 = 0;
    for (const dvec3& side : sides) longest2 = std::max(longest2, glm::dot(side, side));
    const dvec3 middle = (face.a + face.b + face.c) / 3.0;
    const double within = margin + std::sqrt(longest2);
    if (!head_.may_be_within(glm::vec3(middle - c), axis, static_cast<float>(within))) return;
    if (head_.distance(R_TW * (middle - c)) > within) return;
    const int n = std::clamp(static_cast<int>(std::ceil(std::sqrt(longest2) / spacing * (1 - 1e-9))), 1, kMostParts);
    // The face is divided into n² triangles. Each triangle gives a third of its area vector to each of its three
    // corners.
    const dvec3 share = face.normal() / (6.0 * n * n);
    for (int k = 0; k < 3; ++k) add_corner(face.corner(k), share, i);
    if (n == 1) return;
    for (int u = 0; u <= n; ++u) {
      for (int v = 0; v <= n - u; ++v) {
        const int w = n - u - v;
        if (u == n || v == n || w == n) continue;  // this point is a corner of the face itself, which was already added
        const dvec3 p =
            (static_cast<double>(u) * face.a + static_cast<double>(v) * face.b + static_cast<double>(w) * face.c) /
            static_cast<double>(n);
        if (!head_.may_be_within(glm::vec3(p - c), axis, static_cast<float>(margin))) continue;
        if (head_.distance(R_TW * (p - c)) > margin) continue;
        add(p, (u == 0 || v == 0 || w == 0 ? 3.0 : 6.0) * share, i);
      }
    }
  });
  distances_.keep_within(head_, points_, 0, std::numeric_limits<double>::infinity());
  listed_ = true;
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
