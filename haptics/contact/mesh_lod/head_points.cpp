#include "haptics/contact/mesh_lod/head_points.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "haptics/contact/vertex/face_points.h"

namespace typodont::haptics::mesh_lod {

namespace {

std::uint64_t hash_of(const dvec3& p) noexcept {
  std::uint64_t h = std::bit_cast<std::uint64_t>(p.x) * 0x9e3779b97f4a7c15U;
  h = (std::rotl(h, 23) ^ std::bit_cast<std::uint64_t>(p.y)) * 0xbf58476d1ce4e5b9U;
  h = (std::rotl(h, 29) ^ std::bit_cast<std::uint64_t>(p.z)) * 0x94d049bb133111ebU;
  return h;
}

double longest_edge2(const Face& face) noexcept {
  const dvec3 sides[3] = {face.b - face.a, face.c - face.b, face.a - face.c};
  double longest2 = 0;
  for (const dvec3& side : sides) longest2 = std::max(longest2, glm::dot(side, side));
  return longest2;
}

/// Number of contact points on a face in addition to its corners, if each of its edges is divided into n parts.
std::size_t points_on(int n) noexcept {
  return static_cast<std::size_t>((n + 1) * (n + 2) / 2 - 3);
}

}  // namespace

HeadLister::HeadLister() : slots_(std::size_t{1} << kSlotBits) {
  found_.reserve(HeadPoints::kMost);
  near_.reserve(HeadPoints::kMost);
}

void HeadLister::begin(const TriangleGrid& grid, const vertex::VertexHead& head, const Pose& X, double margin,
                       double kept, HeadPoints& list) noexcept {
  R_WT_ = glm::dmat3(glm::mat3_cast(X.R));
  list.points.clear(X);
  list.areas.clear();
  list.margin = margin, list.kept = kept;
  std::ranges::fill(slots_, kFree);
  found_.clear();
  at_ = 0;
  open_ = true;
  const dvec3 half = head.half_box(R_WT_[2]) + margin;
  grid.for_near(X.p - half, X.p + half, [&](std::uint32_t i) {
    if (!grid.box_within(i, X.p, head.reach() + margin)) return;
    if (found_.size() == found_.capacity()) {
      work(grid, head, list);
      found_.clear();
      at_ = 0;
      open_ = true;
    }
    found_.push_back(i);
  });
}

bool HeadLister::work(const TriangleGrid& grid, const vertex::VertexHead& head, HeadPoints& list, int most) noexcept {
  const dvec3 c = list.points.listed_at().p;
  const glm::vec3 axis(R_WT_[2]);
  // First selects the faces near the head, by the distance of each face's centre from the head.
  near_.clear();
  distances_.clear();
  std::size_t effort = 0;
  for (; at_ < found_.size() && effort < static_cast<std::size_t>(most); ++at_) {
    ++effort;
    const Face& face = grid.face(found_[at_]);
    const double longest2 = longest_edge2(face), longest = std::sqrt(longest2);
    const dvec3 middle = (face.a + face.b + face.c) / 3.0 - c;
    if (!head.may_be_within(glm::vec3(middle), axis, static_cast<float>(list.margin + longest))) continue;
    distances_.add(static_cast<std::uint32_t>(near_.size()), middle);
    near_.push_back({found_[at_], longest});
    effort += 3 + static_cast<std::size_t>(longest2 / (spacing(head) * spacing(head)) / 2);
  }
  distances_.evaluate(head, R_WT_, std::numeric_limits<double>::infinity());
  std::size_t kept = 0;
  for (std::size_t k = 0; k < distances_.size(); ++k) {
    const NearFace face = near_[distances_.point(k)];
    if (distances_.distance(k) <= list.margin + face.longest) near_[kept++] = face;
  }
  near_.resize(kept);
  const std::size_t first = list.points.size();
  list_points(grid, head, list);
  distances_.keep_within(head, list.points, first, std::numeric_limits<double>::infinity());
  if (at_ == found_.size()) open_ = false;
  return !open_;
}

bool HeadLister::is_free(const TriangleGrid& grid, const vertex::VertexHead& head, const Pose& X) noexcept {
  const dvec3 half = head.half_box(X.R * dvec3(0, 0, 1));
  bool free = true;
  grid.for_near(X.p - half, X.p + half, [&](std::uint32_t i) {
    const Face& face = grid.face(i);
    const int n = vertex::parts_of(std::sqrt(longest_edge2(face)), spacing(head));
    free = free && vertex::is_outside(head, X, face.a, face.b, face.c, n);
  });
  return free;
}

/// Adds the corner p of a face. Equal corners of adjacent faces become one point with the sum of their areas.
void HeadLister::add_corner(const dvec3& p, const HeadPoints::PointArea& point_area, HeadPoints& list) noexcept {
  std::size_t slot = hash_of(p) >> (64 - kSlotBits);
  for (; slots_[slot] != kFree; slot = (slot + 1) & (slots_.size() - 1)) {
    if (list.points[slots_[slot]] != p) continue;
    list.areas[slots_[slot]].area += point_area.area;
    return;
  }
  if (list.points.full()) return;
  slots_[slot] = static_cast<std::uint32_t>(list.points.size());
  list.points.add(p);
  list.areas.push_back(point_area);
}

/// Adds the corners of the faces in near_ to the contact points, and the additional points on large faces.
void HeadLister::list_points(const TriangleGrid& grid, const vertex::VertexHead& head, HeadPoints& list) noexcept {
  const glm::vec3 axis(R_WT_[2]);
  const dvec3 c = list.points.listed_at().p;
  // The face is divided into small triangles; the area of each is divided equally among its three corners.
  const auto each_point = [&](const Face& face, int n, auto&& use) {
    vertex::each_face_point(face.a, face.b, face.c, n, use);
  };
  for (std::size_t first = 0, last = 0; first < near_.size(); first = last) {
    // Computes the distances of faces' centres from the head, for as many faces as the buffer holds.
    distances_.clear();
    std::uint32_t number = 0;
    for (last = first; last < near_.size(); ++last) {
      const int n = vertex::parts_of(near_[last].longest, spacing(head));
      if (last > first && distances_.size() + points_on(n) > distances_.most()) break;
      if (n == 1) continue;
      each_point(grid.face(near_[last].face), n, [&](const dvec3& p, double) {
        if (head.may_be_within(glm::vec3(p - c), axis, static_cast<float>(list.margin))) distances_.add(number, p - c);
        ++number;
      });
    }
    distances_.evaluate(head, R_WT_, list.margin);
    std::size_t next = 0;
    number = 0;
    for (std::size_t k = first; k < last; ++k) {
      const Face& face = grid.face(near_[k].face);
      const int n = vertex::parts_of(near_[k].longest, spacing(head));
      const dvec3 corner_area = face.normal() / (6.0 * n * n);
      for (int corner = 0; corner < 3; ++corner) add_corner(face.corner(corner), {corner_area, face.tissue}, list);
      if (n == 1) continue;
      each_point(face, n, [&](const dvec3& p, double weight) {
        if (next < distances_.size() && distances_.point(next) == number) {
          if (list.points.add(p)) list.areas.push_back({weight * corner_area, face.tissue});
          ++next;
        }
        ++number;
      });
    }
  }
}

}  // namespace typodont::haptics::mesh_lod
