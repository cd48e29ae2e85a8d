#include "engine/render/handpiece_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/render/srgb.h"

namespace typodont::render {

namespace {

using glm::dvec2;

constexpr int kMinAround = 8, kMaxAround = 40;
// Distance between rings on smooth parts, in units of a triangle's side.
constexpr double kLongStep = 2;
// Two pieces of the outline that meet at a larger angle than this form an edge, rad.
constexpr double kSharp = 35 * kDegree;
constexpr double kBandEdge = 0.02e-3;        // m, width of the soft edge of a coloured band
const dvec3 kBandColor(0.035, 0.035, 0.04);  // sRGB, colour of a band on a handpiece

/// A ring of the mesh: its position, and the path length up to it.
struct Ring {
  double x, z, radius;
  double s;  // m, path length
};

/// Catmull-Rom curve through a, b, c, d: t = 0 gives b, t = 1 gives c.
double through(double a, double b, double c, double d, double t) {
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

/// Rings of a part, with additional ones on smooth curves, and at the ends of bands and knurling.
std::vector<Ring> rings_of(const HandpiecePart& part, double side) {
  std::vector<Ring> fine;
  const auto& given = part.rings;
  const auto take = [&](double x, double z, double radius) {
    const double s = fine.empty() ? 0 : fine.back().s + std::hypot(x - fine.back().x, z - fine.back().z);
    fine.push_back({x, z, std::max(radius, 0.0), s});
  };
  for (std::size_t i = 0; i < given.size(); ++i) {
    take(given[i].x, given[i].z, given[i].radius);
    if (!part.smooth || i + 1 == given.size()) continue;
    const HandpieceRing &a = given[i ? i - 1 : 0], &b = given[i], &c = given[i + 1],
                        &d = given[std::min(i + 2, given.size() - 1)];
    const int steps = std::clamp(static_cast<int>(std::hypot(c.x - b.x, c.z - b.z) / (kLongStep * side)), 1, 5);
    for (int k = 1; k < steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      take(through(a.x, b.x, c.x, d.x, t), through(a.z, b.z, c.z, d.z, t),
           through(a.radius, b.radius, c.radius, d.radius, t));
    }
  }
  std::vector<double> cuts;
  for (const auto& band : part.bands)
    for (const double edge : band) cuts.insert(cuts.end(), {edge - kBandEdge / 2, edge + kBandEdge / 2});
  if (part.knurl[1] > part.knurl[0]) cuts.insert(cuts.end(), part.knurl.begin(), part.knurl.end());
  std::sort(cuts.begin(), cuts.end());
  std::vector<Ring> out{fine.front()};
  for (std::size_t i = 1; i < fine.size(); ++i) {
    const Ring a = fine[i - 1], b = fine[i];
    for (const double s : cuts) {
      if (!(s > a.s + 1e-9 && s < b.s - 1e-9)) continue;
      const double t = (s - a.s) / (b.s - a.s);
      out.push_back({glm::mix(a.x, b.x, t), glm::mix(a.z, b.z, t), glm::mix(a.radius, b.radius, t), s});
    }
    out.push_back(b);
  }
  return out;
}

/// Adds a part that is rotated about z by `turn` (rad). `side`: side of triangles, m.
void add_part(HandpieceMesh& mesh, const HandpiecePart& part, double turn, double side) {
  const std::vector<Ring> rings = rings_of(part, side);
  double widest = 0, off_axis = 0;
  for (const Ring& r : rings) {
    widest = std::max(widest, r.radius);
    off_axis = std::max(off_axis, std::abs(r.x));
  }
  const int around = std::clamp(static_cast<int>(std::lround(2 * kPi * widest / side)), kMinAround, kMaxAround);
  const double knurls = std::max(std::round(2 * kPi * widest / kKnurlPitch), 1.0);
  const dquat R = glm::angleAxis(turn, dvec3(0, 0, 1));
  const auto n = rings.size();
  // Unit direction of the path (x, z) at ring i. If all rings are centred on the tool's axis, the direction is +z,
  // because such rings may be listed in any order of z.
  const auto path = [&](std::size_t i) {
    if (off_axis == 0) return dvec2(0, 1);
    std::size_t lo = i, hi = i;
    while (lo > 0 && rings[i].s - rings[lo].s < 1e-9) --lo;
    while (hi + 1 < n && rings[hi].s - rings[i].s < 1e-9) ++hi;
    return glm::normalize(dvec2(rings[hi].x - rings[lo].x, rings[hi].z - rings[lo].z));
  };
  // Unit normal between ring i and the next: x away from the path, y along it.
  const auto slope = [&](std::size_t i) {
    const Ring &a = rings[i], &b = rings[i + 1];
    const double along = off_axis == 0 ? b.z - a.z : b.s - a.s, out = b.radius - a.radius;
    const double length = std::hypot(along, out);
    return length > 1e-12 ? dvec2(along, -out) / length : dvec2(1, 0);
  };
  const auto add_ring = [&](std::size_t i, const dvec2& normal) {
    const Ring& ring = rings[i];
    const dvec2 t = path(i);
    const dvec3 along(t.x, 0, t.y), across(t.y, 0, -t.x), middle(ring.x, 0, ring.z);
    const bool banded = std::any_of(part.bands.begin(), part.bands.end(),
                                    [&](const auto& b) { return ring.s > b[0] && ring.s < b[1]; });
    const bool knurled =
        part.knurl[1] > part.knurl[0] && ring.s >= part.knurl[0] - 1e-9 && ring.s <= part.knurl[1] + 1e-9;
    // The first and the last corner of a ring lie at the same point, but have different values of `grip`.
    for (int k = 0; k <= around; ++k) {
      const double angle = 2 * kPi * (k % around) / around, c = std::cos(angle), s = std::sin(angle);
      HandpieceVertex v;
      v.p = glm::vec3(R * (middle + ring.radius * (c * across + part.width * s * dvec3(0, 1, 0))));
      v.n = glm::vec3(R * glm::normalize(normal.x * (part.width * c * across + s * dvec3(0, 1, 0)) + normal.y * along));
      v.middle = glm::vec3(R * middle);
      v.around = glm::vec3(R * glm::normalize(-s * across + part.width * c * dvec3(0, 1, 0)));
      v.color = glm::vec3(linear_light(banded ? kBandColor : part.color));
      v.look = {static_cast<float>(banded ? 0.5 : part.roughness), part.brushed ? 1.0f : 0.0f, part.metal ? 1.0f : 0.0f,
                static_cast<float>(part.glow)};
      v.grip = {static_cast<float>(ring.s), static_cast<float>(kKnurlPitch * knurls * k / around),
                knurled ? 1.0f : 0.0f};
      mesh.vertices.push_back(v);
    }
    return static_cast<std::uint32_t>(mesh.vertices.size()) - static_cast<std::uint32_t>(around) - 1;
  };
  const auto corner = [&](std::uint32_t ring, int k) { return ring + static_cast<std::uint32_t>(k); };
  // At an edge, the ring is stored twice, once with each normal.
  std::uint32_t from = 0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const dvec2 here = slope(i);
    const auto shared = [&](std::size_t other) {
      const dvec2 there = slope(other);
      return std::acos(std::clamp(glm::dot(here, there), -1.0, 1.0)) < kSharp ? glm::normalize(here + there) : here;
    };
    const bool joined = i > 0 && glm::dot(slope(i - 1), here) > std::cos(kSharp);
    if (!joined) from = add_ring(i, here);
    const std::uint32_t to = add_ring(i + 1, i + 2 < n ? shared(i + 1) : here);
    for (int k = 0; k < around; ++k) {
      const std::uint32_t a = corner(from, k), b = corner(from, k + 1), c = corner(to, k + 1), d = corner(to, k);
      if (rings[i].radius > 0) mesh.indices.insert(mesh.indices.end(), {a, b, c});
      if (rings[i + 1].radius > 0) mesh.indices.insert(mesh.indices.end(), {a, c, d});
    }
    from = to;
  }
  // Adds flat discs, which close both ends of the part.
  for (const bool last : {false, true}) {
    const std::size_t i = last ? n - 1 : 0;
    if (rings[i].radius <= 0) continue;
    const std::uint32_t rim = add_ring(i, {0, last ? 1.0 : -1.0});
    HandpieceVertex middle = mesh.vertices[rim];
    middle.p = middle.middle;
    mesh.vertices.push_back(middle);
    const auto center = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
    for (int k = 0; k < around; ++k) {
      const std::uint32_t a = corner(rim, k), b = corner(rim, k + 1);
      if (last)
        mesh.indices.insert(mesh.indices.end(), {center, a, b});
      else
        mesh.indices.insert(mesh.indices.end(), {center, b, a});
    }
  }
}

/// Cone from the first to the last ring; each radius is the largest one in its half of the path.
RoundCone cone_about(const std::vector<HandpieceRing>& rings) {
  RoundCone cone;
  if (rings.empty()) return cone;
  const dvec3 first(rings.front().x, 0, rings.front().z), last(rings.back().x, 0, rings.back().z);
  const double length2 = glm::dot(last - first, last - first);
  for (const HandpieceRing& r : rings) {
    const double t = length2 > 0 ? glm::dot(dvec3(r.x, 0, r.z) - first, last - first) / length2 : 0;
    double& radius = t < 0.5 ? cone.ra : cone.rb;
    radius = std::max(radius, r.radius);
  }
  cone.a = first, cone.b = last;
  return cone;
}

}  // namespace

HandpieceMesh make_handpiece_mesh(const Handpiece& handpiece, double side) {
  HandpieceMesh mesh;
  std::vector<HandpieceRing> head, body;
  for (const HandpiecePart& part : handpiece.parts) {
    for (int k = 0; k < part.repeat; ++k) add_part(mesh, part, 2 * kPi * k / part.repeat, side);
    if (part.repeat > 1) continue;
    const bool about_axis = std::all_of(part.rings.begin(), part.rings.end(), [](const auto& r) { return r.x == 0; });
    auto& rings = about_axis ? head : body;
    rings.insert(rings.end(), part.rings.begin(), part.rings.end());
  }
  if (mesh.indices.size() / 3 > kMaxHandpieceTriangles)
    throw Error("", "handpiece \"" + handpiece.name + "\"", fmt::format("{} triangles", mesh.indices.size() / 3),
                fmt::format("at most {}: fewer rings or copies", kMaxHandpieceTriangles));
  const auto sorted = [](std::vector<HandpieceRing>& rings, auto key) {
    std::stable_sort(rings.begin(), rings.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  };
  sorted(head, [](const HandpieceRing& r) { return r.z; });
  sorted(body, [](const HandpieceRing& r) { return std::hypot(r.x, r.z); });
  mesh.head = cone_about(head);
  mesh.body = cone_about(body);
  return mesh;
}

}  // namespace typodont::render
