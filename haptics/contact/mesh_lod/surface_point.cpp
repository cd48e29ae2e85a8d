#include "haptics/contact/mesh_lod/surface_point.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "engine/base/dispatch.h"
#include "engine/base/nearest.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics::mesh_lod {

namespace {

constexpr int kMaxIterations = 24;  // largest number of iterations per follow()
constexpr double kStays = 1e-11;    // m; a shorter step of the ball ends the iteration
constexpr double kMinReach = 5e-6;  // m from the ball's surface, smallest search distance for faces
// m, largest search distance for faces; longer motions of the hand are divided
constexpr double kMaxReach = 0.3e-3;
constexpr double kAhead = 1.1;  // search distance for faces divided by the ball's expected motion
// m, largest motion of the ball for which collected faces are used; also limited by the width of a grid cell
constexpr double kMaxKept = 0.3e-3;
// Search distance for faces divided by the ball's radius, while the tool cuts or is in the hole that it cut.
constexpr double kReachInCut = 0.5;
// Motion, in radii of the ball, up to which collected faces are used while the tool cuts or is in its own hole.
constexpr double kKeptInCut = 0.15;
constexpr double kMinInCut = 50e-6;  // m, lower limit of kReachInCut × radius
// search distance for faces in the next iteration divided by the length of the last step
constexpr double kNextReach = 0.25;
// Collecting this number of faces takes as long as testing one face.
constexpr int kCollectedPerTest = 4;
// m; a face needs no contact plane if it is at most this far above the contact plane of another face
constexpr double kBelow = 1e-11;
// m; used like kBelow in a first test in single precision; larger than kBelow because of rounding errors
constexpr float kClear = 2e-9f;
constexpr double kWallSkin = 1e-7;  // m, distance that the ball keeps from a wall between tissues
// m, search distance for the surface of a new mesh
constexpr double kMapReach = 2e-3;
constexpr int kMaxLifts = 16;
// round_edge() extends a step only if the cosine between the plane's normal and the direction to the hand is above this
constexpr double kMinAlong = 0.3;
// m; if the ball's centre is nearer to a face than this, the face's normal gives the direction
constexpr double kNoDirection = 1e-13;

/// Lists the boxes (from `lo` to `hi`) within `far` of p. May read up to seven elements beyond the end of the arrays.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
std::size_t list_boxes(const float* const* lo, const float* const* hi, std::size_t count, const float* p, float far,
                       std::uint32_t* at) {
  std::size_t found = 0;
  const float square = far * far;
  for (std::size_t k = 0; k < count; k += 8) {
    F8 distance2 = {};
    for (int axis = 0; axis < 3; ++axis) {
      F8 low, high;
      std::memcpy(&low, lo[axis] + k, sizeof low);
      std::memcpy(&high, hi[axis] + k, sizeof high);
      const F8 below = low - p[axis], above = p[axis] - high;
      F8 off = below > above ? below : above;
      off = off > 0.0f ? off : F8{};
      distance2 += off * off;
    }
    for (unsigned bits = bits_of(distance2 <= square); bits; bits &= bits - 1) {
      at[found++] = static_cast<std::uint32_t>(k) + static_cast<std::uint32_t>(std::countr_zero(bits));
    }
  }
  while (found > 0 && at[found - 1] >= count) --found;
  return found;
}

/// Lists the planes that the point q is behind, or in front of by less than `clear`. A plane: normal · x = -distance; x
/// and q are relative to the same centre.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
std::size_t list_planes_above(const float* const* normal, const float* distance, std::size_t count, const float* q,
                              float clear, std::uint32_t* at) {
  std::size_t found = 0;
  for (std::size_t k = 0; k < count; k += 8) {
    F8 height, n;
    std::memcpy(&height, distance + k, sizeof height);
    for (int axis = 0; axis < 3; ++axis) {
      std::memcpy(&n, normal[axis] + k, sizeof n);
      height += n * q[axis];
    }
    for (unsigned bits = bits_of(height <= clear); bits; bits &= bits - 1) {
      at[found++] = static_cast<std::uint32_t>(k) + static_cast<std::uint32_t>(std::countr_zero(bits));
    }
  }
  while (found > 0 && at[found - 1] >= count) --found;
  return found;
}

constexpr std::size_t kLanes = 8;
// Up to this many faces, nearest_on() for each is faster than find_nearest(), which first copies eight faces. On a
// dental arch of 212,000 vertices, this shortens a tick by 10 % for an explorer, and by 13 % for a bur in a cavity.
constexpr std::size_t kFewFaces = 6;

/// Input and output of find_nearest(), one face in each lane.
struct EightFaces {
  D8 a[3], b[3], c[3];                      // m, corners of the faces
  double p[3][kLanes];                      // m, nearest point of each face
  double n[3][kLanes];                      // unit vector from the nearest point to the given point
  double square[kLanes], distance[kLanes];  // m² and m, squared distance and distance
  // index of the edge with the nearest point; -1: interior
  double edge[kLanes];
  unsigned corner = 0;  // bit mask, one bit per face: its nearest point is a corner
};

/// Computes nearest_on() for eight faces at once, with the same operations and so the same result.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void find_nearest(EightFaces& faces, const double* point) {
  const D8 zero = {};
  D8 e[3], f[3], v[3], best[3];
  for (int k = 0; k < 3; ++k) {
    e[k] = faces.b[k] - faces.a[k], f[k] = faces.c[k] - faces.a[k], v[k] = point[k] - faces.a[k];
    best[k] = zero;
  }
  const D8 ee = e[0] * e[0] + e[1] * e[1] + e[2] * e[2], ef = e[0] * f[0] + e[1] * f[1] + e[2] * f[2],
           ff = f[0] * f[0] + f[1] * f[1] + f[2] * f[2];
  const D8 ve = v[0] * e[0] + v[1] * e[1] + v[2] * e[2], vf = v[0] * f[0] + v[1] * f[1] + v[2] * f[2];
  const D8 det = ee * ff - ef * ef, s = ff * ve - ef * vf, t = ee * vf - ef * ve;
  const L8 interior = (det > kSliver * ee * ff) & (s >= 0.0) & (t >= 0.0) & (s + t <= det);
  D8 best2 = zero + 1e300, edge = zero - 1.0;
  L8 corner = {};
  for (int i = 0; i < 3; ++i) {
    const D8* const from = i == 0 ? faces.a : i == 1 ? faces.b : faces.c;
    const D8* const to = i == 0 ? faces.b : i == 1 ? faces.c : faces.a;
    D8 direction[3], off[3], q[3];
    for (int k = 0; k < 3; ++k) direction[k] = to[k] - from[k], off[k] = point[k] - from[k];
    const D8 along = off[0] * direction[0] + off[1] * direction[1] + off[2] * direction[2],
             square = direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2];
    D8 part = along / square;
    part = part < 0.0 ? zero : part;
    part = part > 1.0 ? zero + 1.0 : part;
    part = square > 0.0 ? part : zero;
    for (int k = 0; k < 3; ++k) q[k] = from[k] + part * direction[k], off[k] = point[k] - q[k];
    const D8 d2 = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
    const L8 closer = d2 < best2;
    for (int k = 0; k < 3; ++k) best[k] = closer ? q[k] : best[k];
    const L8 at_end = (part == 0.0) | (part == 1.0);
    corner = closer ? at_end : corner;
    edge = closer ? zero + i : edge;
    best2 = closer ? d2 : best2;
  }
  faces.corner = bits_of(corner & ~interior);
  D8 off[3];
  for (int k = 0; k < 3; ++k) {
    best[k] = interior ? faces.a[k] + (s * e[k] + t * f[k]) / det : best[k];
    off[k] = point[k] - best[k];
    write_lanes(faces.p[k], best[k]);
  }
  write_lanes(faces.edge, interior ? zero - 1.0 : edge);
  const D8 square = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
  D8 distance = square;
  take_root(distance);
  write_lanes(faces.square, square);
  write_lanes(faces.distance, distance);
  for (int k = 0; k < 3; ++k) write_lanes(faces.n[k], off[k] / distance);
}

dvec3 unit_or(const dvec3& v, const dvec3& other) noexcept {
  const double size = glm::length(v);
  return size > 0 ? v / size : other;
}

}  // namespace

double SurfacePoint::clearance(const TriangleGrid& grid, const dvec3& p, double most) noexcept {
  return grid.nearest(p, most + radius()).distance - radius();
}

void SurfacePoint::put_free(const dvec3& p) noexcept {
  c_ = p;
  count_ = 0;
  ground_ = Tissue::kAir;
  behind_ = false;
}

bool SurfacePoint::put(const TriangleGrid& grid, const dvec3& p) noexcept {
  put_free(p);
  const TriangleGrid::Nearest near = grid.nearest(p, kMapReach);
  const bool inside = grid.inside(p);
  if (!inside && !(near.found && near.distance < radius())) return true;
  // too deep to find a surface: the ball stays here
  if (!near.found) return false;
  const dvec3 out = unit_or(inside ? near.p - p : p - near.p, unit_or(grid.face(near.face).normal(), {0, 0, 1}));
  lift(grid, out);
  return false;
}

/// Moves the ball to the nearest surface on the side of n, until it overlaps no face.
bool SurfacePoint::lift(const TriangleGrid& grid, dvec3 n) noexcept {
  for (int i = 0; i < kMaxLifts; ++i) {
    const TriangleGrid::Nearest near = grid.nearest(c_, kMapReach + radius());
    if (!near.found) return false;
    const dvec3 off = c_ - near.p;
    const bool outside = glm::dot(off, n) >= 0;
    if (outside && near.distance >= radius() * (1 - 1e-12)) return true;
    if (near.distance > kNoDirection && outside)
      n = off / near.distance;
    else if (const dvec3 face = unit_or(grid.face(near.face).normal(), n); near.distance <= kNoDirection)
      n = glm::dot(face, n) >= 0 ? face : -face;
    else
      n = -off / near.distance;
    c_ = near.p + radius() * (1 + 1e-9) * n;
  }
  return false;
}

void SurfacePoint::map_to(const TriangleGrid& grid) noexcept {
  if (count_ == 0) {
    if (grid.inside(c_)) put(grid, c_);
    return;
  }
  dvec3 n(0);
  for (int i = 0; i < count_; ++i) {
    if (!hold(i).wall) n += hold(i).push * hold(i).n;
  }
  // Point of the new mesh nearest to the old contact.
  const TriangleGrid::Nearest near = grid.nearest(c_, kMapReach);
  if (!near.found) return;
  n = unit_or(n, hold(0).n);
  const dvec3 face = unit_or(grid.face(near.face).normal(), n);
  const dvec3 side = glm::dot(face, n) >= 0 ? face : -face;
  const dvec3 off = c_ - near.p;
  if (near.distance > kNoDirection && glm::dot(off, side) >= 0)
    c_ = near.p + radius() * (1 + 1e-9) * (off / near.distance);
  else
    c_ = near.p + radius() * (1 + 1e-9) * side;
  lift(grid, side);
}

/// Collects the faces within `reach` (m) of the ball.
void SurfacePoint::collect(const TriangleGrid& grid, double reach) noexcept {
  for (;;) {
    near_count_ = 0;
    bool all = true;
    const double far = radius() + reach;
    const auto collect_face = [&](std::uint32_t i) {
      if (!grid.box_within(i, c_, far)) return;
      if (near_count_ == kMaxNear) {
        all = false;
        return;
      }
      const auto at = static_cast<std::size_t>(near_count_++);
      const TriangleGrid::Box& box = grid.box(i);
      near_[at] = i;
      boxes_.lo_x[at] = box.lo.x, boxes_.lo_y[at] = box.lo.y, boxes_.lo_z[at] = box.lo.z;
      boxes_.hi_x[at] = box.hi.x, boxes_.hi_y[at] = box.hi.y, boxes_.hi_z[at] = box.hi.z;
    };
    if (grid.has_blocks()) {
      grid.for_near_blocks(c_ - far, c_ + far, collect_face);
    } else {
      grid.for_near(c_ - far, c_ + far, collect_face);
    }
    collected_ = &grid;
    near_from_ = c_;
    near_reach_ = reach;
    tested_ += near_count_ / kCollectedPerTest;
    if (all || reach < kStays) return;
    reach /= 2;
  }
}

/// Collected faces within `within` (m) of the ball's centre, as indices into near_.
std::span<const std::uint32_t> SurfacePoint::close_faces(const TriangleGrid& grid, double within) noexcept {
  const glm::vec3 p(c_ - grid.origin());
  const float* const lo[3] = {boxes_.lo_x, boxes_.lo_y, boxes_.lo_z};
  const float* const hi[3] = {boxes_.hi_x, boxes_.hi_y, boxes_.hi_z};
  const float far = static_cast<float>(within) + TriangleGrid::kBoxRounding;
  return {close_.data(), list_boxes(lo, hi, static_cast<std::size_t>(near_count_), &p.x, far, close_.data())};
}

/// Adds walls: the edges of `face` to softer tissue.
void SurfacePoint::add_walls(const Face& face, std::uint32_t index, std::uint64_t order, double reach,
                             bool& fits) noexcept {
  if (!options_.walls || behind_ || ground_ == Tissue::kAir || stiffness_of(ground_) >= stiffness_of(face.tissue))
    return;
  const dvec3 up = unit_or(face.normal(), dvec3(0));
  for (int k = 0; k < 3; ++k) {
    const Tissue soft = face.across[static_cast<std::size_t>(k)];
    if (soft == Tissue::kAir || stiffness_of(soft) >= stiffness_of(face.tissue)) continue;
    const dvec3 a = face.corner(k), b = face.corner((k + 1) % 3);
    const dvec3 q = nearest_on_segment(a, b, c_ - glm::dot(c_ - a, up) * up);
    dvec3 off = c_ - q;
    off -= glm::dot(off, up) * up;
    const dvec3 away = unit_or(glm::cross(b - a, up), dvec3(0));
    // the ball is already behind this wall between tissues, so the wall cannot stop the ball
    if (glm::dot(off, away) < 0) continue;
    const double distance = glm::length(off);
    if (distance > reach + kWallSkin) continue;
    fits = planes_.add({distance > kNoDirection ? off / distance : away, std::max(distance - kWallSkin, 0.0), q, order,
                        index, static_cast<std::int8_t>(k)}) &&
           fits;
  }
}

/// Adds the planes of all faces within `reach` (m) of the ball. Returns false if there are too many.
bool SurfacePoint::collect_planes(const TriangleGrid& grid, double reach, bool give) noexcept {
  planes_.clear();
  const double r = radius();
  bool fits = true;
  // Faces whose interior is nearest come first. A face whose edge is nearest gets no plane if it is below such a plane.
  int edge_count = 0;
  const auto add = [&](std::uint32_t i, std::uint64_t order, const dvec3& n, double distance, const dvec3& p) {
    double free = distance - r;
    if (give) free = std::max(free, 0.0);
    if (free <= reach) fits = planes_.add({n, free, p, order, i, -1}) && fits;
  };
  const std::span<const std::uint32_t> close = close_faces(grid, r + reach);
  tested_ += static_cast<int>(close.size());
  inner_of_.clear();
  const double far = r + reach;
  const auto add_face = [&](std::uint32_t near, const OnFace& at, const dvec3& n, double distance) {
    const std::uint32_t i = near_[near];
    if (at.edge >= 0) {
      edges_[static_cast<std::size_t>(edge_count++)] = {i, near, at, n, distance};
      return;
    }
    const auto j = static_cast<std::size_t>(planes_.count());
    add(i, near, n, distance, at.p);
    if (planes_.count() == static_cast<int>(j)) return;
    inner_of_.add(i, static_cast<std::uint32_t>(j));
    inner_.x[j] = static_cast<float>(n.x), inner_.y[j] = static_cast<float>(n.y), inner_.z[j] = static_cast<float>(n.z);
    inner_.distance[j] = static_cast<float>(distance);
  };
  const auto normal_of = [&](std::uint32_t near) { return unit_or(grid.face(near_[near]).normal(), {0, 0, 1}); };
  std::size_t first = 0;
  EightFaces eight;
  for (; first + kFewFaces < close.size(); first += kLanes) {
    const std::size_t count = std::min(kLanes, close.size() - first);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const Face& face = grid.face(near_[close[first + (lane < count ? lane : 0)]]);
      for (int k = 0; k < 3; ++k)
        eight.a[k][lane] = face.a[k], eight.b[k][lane] = face.b[k], eight.c[k][lane] = face.c[k];
    }
    find_nearest(eight, &c_.x);
    for (std::size_t lane = 0; lane < count; ++lane) {
      if (eight.square[lane] > far * far) continue;
      const OnFace at{{eight.p[0][lane], eight.p[1][lane], eight.p[2][lane]},
                      static_cast<int>(eight.edge[lane]),
                      (eight.corner >> lane & 1) != 0};
      const double distance = eight.distance[lane];
      add_face(close[first + lane], at,
               distance > kNoDirection ? dvec3(eight.n[0][lane], eight.n[1][lane], eight.n[2][lane])
                                       : normal_of(close[first + lane]),
               distance);
    }
  }
  for (; first < close.size(); ++first) {
    const OnFace at = nearest_on(grid.face(near_[close[first]]), c_);
    const dvec3 off = c_ - at.p;
    const double square = glm::dot(off, off), distance = std::sqrt(square);
    if (square > far * far) continue;
    add_face(close[first], at, distance > kNoDirection ? off / distance : normal_of(close[first]), distance);
  }
  const int insides = planes_.count();
  const float* const normals[3] = {inner_.x, inner_.y, inner_.z};
  std::uint32_t found = kNoPlane;  // index of the plane below which the last omitted face lies
  for (int k = 0; k < edge_count; ++k) {
    const auto& [i, near, at, n, distance] = edges_[static_cast<std::size_t>(k)];
    const std::uint64_t order = near | kOfEdge;
    const Face& face = grid.face(i);
    // If a face is completely below another face's plane, the ball meets that plane first, so the face gets no plane.
    // Tests first the plane of the adjacent face at the nearest edge, then the last plane found.
    const auto below = [&](std::uint32_t j) {
      const Plane& plane = planes_[static_cast<int>(j)];
      const double most = std::max({glm::dot(plane.n, face.a - plane.p), glm::dot(plane.n, face.b - plane.p),
                                    glm::dot(plane.n, face.c - plane.p)});
      if (most <= kBelow) found = j;
      return most <= kBelow;
    };
    const std::uint32_t next = inner_of_.find(face.beyond[static_cast<std::size_t>(at.edge)]);
    const auto covered = [&] {
      if ((next != kNoPlane && below(next)) || (found != kNoPlane && below(found))) return true;
      const glm::vec3 q(at.p - c_);
      const std::size_t above =
          list_planes_above(normals, inner_.distance, static_cast<std::size_t>(insides), &q.x, kClear, above_.data());
      return std::any_of(above_.begin(), above_.begin() + static_cast<std::ptrdiff_t>(above), below);
    };
    if (covered()) continue;
    // If the surface is flat or concave at this edge, the face's own plane is valid. The plane at the edge would be
    // valid too, but the search would converge slowly with it.
    if (const dvec3 normal = face.normal(); !at.corner && normal != dvec3(0)) {
      const double size = glm::length(normal), height = glm::dot(normal, c_ - face.a) / size;
      const std::uint8_t hollow = height >= 0 ? face.hollow_front : face.hollow_back;
      if ((hollow >> at.edge & 1) && std::abs(height) >= r - kBelow && next != kNoPlane) {
        add(i, order, height >= 0 ? normal / size : -normal / size, std::max(std::abs(height), r), at.p);
        continue;
      }
    }
    add(i, order, n, distance, at.p);
  }
  if (options_.walls && !give && ground_ != Tissue::kAir) {
    for (const std::uint32_t k : close) {
      const std::uint32_t i = near_[k];
      if (grid.face(i).across != std::array<Tissue, 3>{}) add_walls(grid.face(i), i, k | kOfWall, reach, fits);
    }
  }
  return fits;
}

/// At an edge or corner of a face, the ball's step to one plane is too short. Extends the step along this plane, to the
/// line between the hand and the face's point nearest to the hand.
void SurfacePoint::round_edge(const TriangleGrid& grid, const dvec3& hip, const Plane& plane,
                              dvec3& step) const noexcept {
  if (plane.wall >= 0 || options_.radius <= kSkin) return;
  const OnFace at = nearest_on(grid.face(plane.face), hip);
  const dvec3 off = hip - at.p;
  const double size = glm::length(off), along = size > kSkin ? glm::dot(off, plane.n) / size : 0;
  if (at.edge < 0 || !(along > kMinAlong)) return;
  const double direction = (glm::dot(plane.n, c_ - at.p) - plane.gap) / along;
  const dvec3 other = at.p + direction / size * off - c_;
  // `other` ends on the line from at.p to the hand. It is not used if it differs from `step` too much.
  if (glm::length(other - step) > glm::length(step)) return;
  for (int i = 0; i < planes_.count(); ++i) {
    if (glm::dot(planes_[i].n, other) < -planes_[i].gap - kStays) return;
  }
  step = other;
}

/// Returns true if the interior of the plane's face touches the ball; the search is then finished. Sets the plane's
/// point to the contact point.
bool SurfacePoint::rests_on(const TriangleGrid& grid, Plane& plane) const noexcept {
  if (plane.wall >= 0) return false;
  const OnFace at = nearest_on(grid.face(plane.face), c_);
  if (at.edge >= 0 || !(std::abs(glm::distance(c_, at.p) - radius()) <= kStays)) return false;
  plane.p = at.p;
  return true;
}

void SurfacePoint::follow(const TriangleGrid& grid, const dvec3& hip, bool give) noexcept {
  gave_way_ = false;
  tested_ = 0;
  ActivePlanes active;
  // Expected motion of the ball. In contact: the hand's motion along the surface, without the part into the surface.
  const dvec3 pull = hip - c_;
  dvec3 along = pull;
  for (int i = 0; i < count_; ++i) along -= std::min(0.0, glm::dot(along, hold(i).n)) * hold(i).n;
  const double near = give ? std::max(kReachInCut * radius(), kMinInCut) : kMaxKept;
  const double kept_in_cut = give ? kKeptInCut * radius() : near;
  const double kept = std::min({grid.cell(), kMaxKept, near, kept_in_cut}), max_reach = std::min(kMaxReach, near);
  // m, search distance of the next iteration
  double wanted = std::clamp(kAhead * glm::length(along) + kMinReach, kMinReach, max_reach);
  if (collected_ != &grid || near_reach_ - glm::distance(c_, near_from_) < wanted) collect(grid, wanted + kept);
  for (int i = 0; i < kMaxIterations; ++i) {
    // m, distance within which the list of faces is complete
    double valid = near_reach_ - glm::distance(c_, near_from_);
    if (valid < kMinReach / 2 && i > 0) {
      collect(grid, wanted + kept);
      valid = near_reach_;
    }
    double left = std::min(valid, wanted);
    while (!collect_planes(grid, left, give) && left > kStays) left /= 2;
    dvec3 step = planes_.nearest_allowed(hip - c_, active);
    if (!behind_) {
      for (int k = 0; k < active.count; ++k) {
        const Plane& plane = planes_[active.index[k]];
        if (plane.wall < 0) continue;
        const double stiffness = stiffness_of(grid.face(plane.face).tissue) / 1000.0 * options_.unit_force;
        if (stiffness * active.push[k] <= options_.wall_limit) continue;
        behind_ = gave_way_ = true;
        beyond_ = grid.face(plane.face).tissue;
      }
      if (gave_way_ && behind_) {
        collect_planes(grid, left, give);
        step = planes_.nearest_allowed(hip - c_, active);
      }
    }
    if (active.count == 1) round_edge(grid, hip, planes_[active.index[0]], step);
    const double size = glm::length(step);
    if (size > left) step *= left / size;
    c_ += step;
    wanted = std::clamp(size > left ? size : kNextReach * size, kMinReach, max_reach);
    if (std::min(size, left) <= kStays || (active.count == 0 && size <= left)) break;
    if (active.count == 0) continue;
    if (tested_ >= kMaxTested) break;
    if (active.count == 1 && size <= left && rests_on(grid, planes_[active.index[0]])) break;
  }
  count_ = 0;
  double most = 0;
  Tissue ground = Tissue::kAir;
  for (int k = 0; k < active.count; ++k) {
    const Plane& plane = planes_[active.index[k]];
    const double push = active.push[k];
    if (!(push > 0)) continue;
    const Face& face = grid.face(plane.face);
    holds_[static_cast<std::size_t>(count_++)] = {plane.p, plane.n, push, face.tissue, plane.wall >= 0};
    if (plane.wall < 0 && push > most) most = push, ground = face.tissue;
  }
  // At a wall between tissues, both tissues may be equally near, so the tissue in contact (ground_) is not changed.
  const bool at_wall = std::any_of(holds_.begin(), holds_.begin() + count_, [](const Hold& h) { return h.wall; });
  if (!at_wall) ground_ = ground;
  if (behind_ && (ground_ == Tissue::kAir || stiffness_of(ground_) >= stiffness_of(beyond_))) behind_ = false;
}

/// Uses the collected faces if they include all faces near the ball; otherwise searches in the grid.
PerTissue SurfacePoint::engaged_area(const TriangleGrid& grid, const dvec3& direction) noexcept {
  PerTissue area{};
  const double within = (1 + kOnHead) * radius();
  const auto add = [&](const Face& face) {
    const dvec3 off = (face.a + face.b + face.c) / 3.0 - c_;
    const double size = -glm::dot(face.normal(), direction) / 2;
    if (size > 0 && glm::dot(off, off) <= within * within) area[static_cast<std::size_t>(face.tissue)] += size;
  };
  if (collected_ != &grid || near_reach_ - glm::distance(c_, near_from_) < kOnHead * radius()) {
    grid.for_near(c_ - within, c_ + within, [&](std::uint32_t i) { add(grid.face(i)); });
  } else {
    for (const std::uint32_t k : close_faces(grid, within)) add(grid.face(near_[k]));
  }
  return area;
}

}  // namespace typodont::haptics::mesh_lod
