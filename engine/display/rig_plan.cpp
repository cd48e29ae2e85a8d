#include "engine/display/rig_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace typodont::display {

namespace {

constexpr double kGlassMargin = 0.01;  // m, width of glass outside the outermost lines of sight

/// Half-space outward · p ≤ offset, with |outward| = 1.
struct Limit {
  dvec3 outward;
  double offset;  // m along `outward`
  std::string name;
};

/// Limit whose plane goes through a, b and c; the point `inside` lies in the half-space.
Limit limit_through(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& inside, std::string name) {
  dvec3 n = glm::normalize(glm::cross(b - a, c - a));
  if (glm::dot(n, inside - a) > 0) n = -n;
  return {n, glm::dot(n, a), std::move(name)};
}

/// Intersection of the line p–q with the plane normal · p = offset.
dvec3 meet(const dvec3& p, const dvec3& q, const dvec3& normal, double offset) {
  const dvec3 d = q - p;
  return p + ((offset - glm::dot(normal, p)) / glm::dot(normal, d)) * d;
}

/// Solves A x = b in place with Cholesky's method.
template <std::size_t N>
void solve(std::array<std::array<double, N>, N>& A, std::array<double, N>& b) {
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = A[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= A[i][k] * A[j][k];
      A[i][j] = i == j ? std::sqrt(sum) : sum / A[j][j];
    }
  }
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t k = 0; k < i; ++k) b[i] -= A[i][k] * b[k];
    b[i] /= A[i][i];
  }
  for (std::size_t i = N; i-- > 0;) {
    for (std::size_t k = i + 1; k < N; ++k) b[i] -= A[k][i] * b[k];
    b[i] /= A[i][i];
  }
}

struct LargestBox {
  dvec3 middle{0, 0, 0}, half{0, 0, 0};  // m
};

/// Largest box that fulfils all limits n · c + |n| · h ≤ d (c: middle, h: half size). Maximises log(h_x h_y h_z), a
/// convex problem (Boyd & Vandenberghe 2004, 8.4.2), with a barrier method.
LargestBox max_box(const std::vector<Limit>& limits) {
  double room = std::numeric_limits<double>::infinity();
  for (const Limit& limit : limits) room = std::min(room, limit.offset);
  // Unknowns: the box's middle c, then its half size h; divided by `room`, so that the numbers are near 1.
  std::array<double, 6> x{0, 0, 0, 0.25 * room, 0.25 * room, 0.25 * room};
  for (double& v : x) v /= room;
  std::vector<std::array<double, 6>> rows;
  std::vector<double> bounds;
  for (const Limit& limit : limits) {
    const dvec3& n = limit.outward;
    rows.push_back({n.x, n.y, n.z, std::abs(n.x), std::abs(n.y), std::abs(n.z)});
    bounds.push_back(limit.offset / room);
  }
  const auto value = [&](const std::array<double, 6>& at, double weight) {
    double sum = 0;
    for (std::size_t i = 3; i < 6; ++i) {
      if (!(at[i] > 0)) return std::numeric_limits<double>::infinity();
      sum -= std::log(at[i]);
    }
    for (std::size_t r = 0; r < rows.size(); ++r) {
      double slack = bounds[r];
      for (std::size_t i = 0; i < 6; ++i) slack -= rows[r][i] * at[i];
      if (!(slack > 0)) return std::numeric_limits<double>::infinity();
      sum -= weight * std::log(slack);
    }
    return sum;
  };
  for (double weight = 1; weight > 1e-12; weight *= 0.2) {
    for (int step = 0; step < 60; ++step) {
      std::array<std::array<double, 6>, 6> H{};
      std::array<double, 6> g{};
      for (std::size_t i = 3; i < 6; ++i) g[i] -= 1 / x[i], H[i][i] += 1 / (x[i] * x[i]);
      for (std::size_t r = 0; r < rows.size(); ++r) {
        double slack = bounds[r];
        for (std::size_t i = 0; i < 6; ++i) slack -= rows[r][i] * x[i];
        for (std::size_t i = 0; i < 6; ++i) {
          g[i] += weight * rows[r][i] / slack;
          for (std::size_t j = 0; j < 6; ++j) H[i][j] += weight * rows[r][i] * rows[r][j] / (slack * slack);
        }
      }
      for (std::size_t i = 0; i < 6; ++i) H[i][i] *= 1 + 1e-13;
      std::array<double, 6> direction = g;
      solve(H, direction);
      double decrement = 0;
      for (std::size_t i = 0; i < 6; ++i) decrement += g[i] * direction[i];
      if (!(decrement > 1e-14)) break;
      const double before = value(x, weight);
      double length = 1;
      std::array<double, 6> next = x;
      do {
        for (std::size_t i = 0; i < 6; ++i) next[i] = x[i] - length * direction[i];
        length *= 0.5;
      } while (length > 1e-14 && !(value(next, weight) <= before - 0.25 * 2 * length * decrement));
      if (!(value(next, weight) < before)) break;
      x = next;
    }
  }
  return {room * dvec3(x[0], x[1], x[2]), room * dvec3(x[3], x[4], x[5])};
}

/// Returns true if the segments a–b and c–d cross in the side view (y, z).
bool cross_in_side_view(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& d) {
  const auto side = [](const dvec3& p, const dvec3& q, const dvec3& r) {
    return (q.y - p.y) * (r.z - p.z) - (q.z - p.z) * (r.y - p.y);
  };
  return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

double distance_in_side_view(const dvec3& p, const dvec3& a, const dvec3& b) {
  const double dy = b.y - a.y, dz = b.z - a.z;
  const double s = std::clamp(((p.y - a.y) * dy + (p.z - a.z) * dz) / (dy * dy + dz * dz), 0.0, 1.0);
  return std::hypot(a.y + s * dy - p.y, a.z + s * dz - p.z);
}

}  // namespace

BenchPlan plan_bench(const BenchSpec& spec) {
  BenchPlan plan;
  DisplayRig& rig = plan.rig;
  rig.kind = DisplayKind::kMirror;

  rig.head.eye_center = spec.eye_distance * dvec3(0, -std::cos(spec.gaze), std::sin(spec.gaze));
  rig.head.ipd = spec.ipd;
  rig.head.right = {1, 0, 0};
  const dvec3 up(0, std::cos(spec.picture_tilt), std::sin(spec.picture_tilt));
  const dvec3 across = 0.5 * spec.panel_width * dvec3(1, 0, 0), along = 0.5 * spec.panel_height * up;
  plan.picture = {-across - along, across - along, -across + along, spec.pixels, spec.layout};
  Mirror mirror;
  mirror.normal = {0, -std::sin(spec.mirror_tilt), std::cos(spec.mirror_tilt)};
  mirror.offset = spec.glass_above_work;
  rig.mirror = mirror;
  // The panel is a mirror image: its left edge is on the user's right.
  rig.screen = {reflect(mirror, across - along), reflect(mirror, -across - along), reflect(mirror, across + along),
                spec.pixels, spec.layout};
  plan.pixel = spec.panel_width / eye_pixels(spec.layout, spec.pixels).x;
  const std::array<dvec3, 2> eyes = {rig.head.eye_center - dvec3(0.5 * spec.ipd, 0, 0),
                                     rig.head.eye_center + dvec3(0.5 * spec.ipd, 0, 0)};

  // Finds the objects that hide the picture from the user.
  const dvec3 towards(0, -up.z, up.y);  // normal of the picture, towards the user
  const auto before_glass = [&](const dvec3& p) { return glm::dot(mirror.normal, p) - mirror.offset; };
  const double to_picture = glm::dot(towards, rig.head.eye_center);
  auto& conflicts = plan.conflicts;
  if (before_glass(rig.head.eye_center) <= 0) {
    conflicts.push_back(
        fmt::format("the eyes are {:.0f} mm behind the glass: lower the mirror or look down more steeply",
                    -1e3 * before_glass(rig.head.eye_center)));
  }
  if (to_picture <= 0.05) conflicts.push_back("the eyes see the picture from its edge or its back: tilt it");
  const std::array<dvec3, 4> corners = {-across - along, across - along, across + along, -across + along};
  bool behind = true;
  for (const dvec3& corner : corners) behind = behind && before_glass(corner) < 0;
  if (!behind) conflicts.push_back("the picture reaches through the glass: raise the mirror or turn the picture");
  if (!conflicts.empty()) return plan;

  // The glass must contain all lines of sight, with a margin.
  const dvec3 slope(0, mirror.normal.z, -mirror.normal.y);  // direction in the glass away from the user
  double near_end = std::numeric_limits<double>::infinity(), far_end = -near_end, half_width = 0;
  for (const dvec3& eye : eyes) {
    for (const dvec3& corner : corners) {
      const dvec3 at = meet(eye, corner, mirror.normal, mirror.offset);
      near_end = std::min(near_end, glm::dot(slope, at)), far_end = std::max(far_end, glm::dot(slope, at));
      half_width = std::max(half_width, std::abs(at.x));
    }
  }
  near_end -= kGlassMargin, far_end += kGlassMargin, half_width += kGlassMargin;
  const dvec3 foot = mirror.offset * mirror.normal, right(1, 0, 0);
  plan.glass = {foot + near_end * slope - half_width * right, foot + near_end * slope + half_width * right,
                foot + far_end * slope + half_width * right, foot + far_end * slope - half_width * right};
  plan.glass_width = 2 * half_width, plan.glass_length = far_end - near_end;

  // Checks that the panel blocks neither view nor head.
  const dvec3 &eye = rig.head.eye_center, edge_a = reflect(mirror, -along), edge_b = reflect(mirror, along);
  const dvec3 glass_near = foot + near_end * slope, glass_far = foot + far_end * slope;
  // True if p is inside the triangle of the eye and the ends of the glass, in the side view.
  const auto within_view = [&](const dvec3& p) {
    const auto side = [](const dvec3& o, const dvec3& a, const dvec3& b) {
      return (a.y - o.y) * (b.z - o.z) - (a.z - o.z) * (b.y - o.y);
    };
    const double s = side(eye, glass_near, p), t = side(eye, p, glass_far), u = side(glass_near, glass_far, p);
    return (s > 0 && t > 0 && u > 0) || (s < 0 && t < 0 && u < 0);
  };
  if (within_view(edge_a) || within_view(edge_b) || cross_in_side_view(eye, glass_near, edge_a, edge_b) ||
      cross_in_side_view(eye, glass_far, edge_a, edge_b)) {
    conflicts.push_back("the panel stands between the eyes and the glass: turn the mirror, or raise it");
  }
  if (cross_in_side_view(glass_near, glass_far, edge_a, edge_b)) conflicts.push_back("the panel cuts the glass");
  const double to_panel = distance_in_side_view(eye, edge_a, edge_b);
  if (to_panel < spec.head_room) {
    conflicts.push_back(fmt::format("the panel is {:.0f} mm from the eyes, and the head needs {:.0f} mm",
                                    1e3 * to_panel, 1e3 * spec.head_room));
  }

  // The workspace is visible to both eyes at a comfortable depth, below the glass, and within reach of the arm.
  std::vector<Limit> limits;
  constexpr const char* kEdges[] = {"the picture's lower edge", "the picture's right edge", "the picture's upper edge",
                                    "the picture's left edge"};
  for (const dvec3& e : eyes) {
    for (std::size_t i = 0; i < 4; ++i)
      limits.push_back(limit_through(e, corners[i], corners[(i + 1) % 4], dvec3(0), kEdges[i]));
  }
  const double picture_dioptres = 1 / to_picture;
  plan.nearest = 1 / (picture_dioptres + spec.comfort);
  limits.push_back({towards, to_picture - plan.nearest, "comfortable depth in front of the picture"});
  if (picture_dioptres > spec.comfort) {
    plan.farthest = 1 / (picture_dioptres - spec.comfort);
    limits.push_back({-towards, plan.farthest - to_picture, "comfortable depth behind the picture"});
  } else {
    plan.farthest = std::numeric_limits<double>::infinity();
  }
  limits.push_back({mirror.normal, mirror.offset - spec.hand_room, "room for the hand below the glass"});
  const dvec3 reach = 0.5 * spec.arm_box;
  for (int axis = 0; axis < 3; ++axis) {
    dvec3 n(0);
    n[axis] = 1;
    limits.push_back({n, reach[axis], "the arm's reach"});
    limits.push_back({-n, reach[axis], "the arm's reach"});
  }
  for (const Limit& limit : limits) {
    if (!(limit.offset > 1e-4))
      conflicts.push_back(
          fmt::format("the middle of the work is outside: {} ({:.0f} mm)", limit.name, 1e3 * limit.offset));
  }
  if (std::any_of(limits.begin(), limits.end(), [](const Limit& limit) { return !(limit.offset > 1e-4); })) return plan;
  const LargestBox box = max_box(limits);
  plan.low = box.middle - box.half, plan.high = box.middle + box.half;

  // For each face of the box: finds the nearest limit in its direction.
  for (std::size_t f = 0; f < 6; ++f) {
    const auto axis = static_cast<int>(f / 2);
    const double sign = f % 2 ? 1 : -1;
    Face& face = plan.faces[f];
    face.outward[axis] = sign;
    double least = std::numeric_limits<double>::infinity();
    for (const Limit& limit : limits) {
      const double rate = std::max(0.0, sign * limit.outward[axis]);
      if (rate < 1e-9) continue;
      const double slack =
          limit.offset - glm::dot(limit.outward, box.middle) - glm::dot(glm::abs(limit.outward), box.half);
      if (slack / rate < least - 1e-9) least = slack / rate, face.limit = limit.name;
    }
  }
  return plan;
}

}  // namespace typodont::display
