#include "tests/support/tooth_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/base/units.h"

namespace typodont::test {

namespace {

using glm::dvec3;
using glm::ivec3;

struct Body {
  double cavity;

  static double smooth_min(double a, double b, double k) {
    const double h = std::clamp(0.5 + 0.5 * (b - a) / k, 0.0, 1.0);
    return b + (a - b) * h - k * h * (1 - h);
  }
  /// Returns the signed distance (mm, negative inside) of the outer shape: a rounded crown with four cusps and two
  /// crossing grooves, and a tapered root.
  static double form(const dvec3& p) {
    const double crown = (std::pow(std::pow(std::abs(p.x) / 5.0, 3.0) + std::pow(std::abs(p.y) / 4.5, 3.0), 2.0 / 3.0) +
                          std::pow((p.z - 0.3) / 3.6, 2.0));
    double d = (std::sqrt(crown) - 1) * 4.0;
    const double cusps = 0.75 * std::cos(p.x * 1.25) * std::cos(p.y * 1.35);
    if (p.z > 0) d += 0.85 * cusps * std::clamp(p.z / 3.0, 0.0, 1.0);
    const double taper = 3.2 + 0.28 * std::min(p.z, 0.0);
    const double root = std::max(std::sqrt(p.x * p.x + 1.2 * p.y * p.y) - taper, -9.0 - p.z);
    return smooth_min(d, std::max(root, p.z - 0.5), 1.4);
  }
  double operator()(const dvec3& p) const {
    const double outer = form(p);
    if (cavity <= 0) return outer;
    const double cut = std::max(std::hypot(p.x * 0.8, p.y) - 1.6, 3.2 - cavity * 1e3 - p.z);
    return std::max(outer, -cut);
  }
  /// Distance outside the lesion, mm.
  double lesion(const dvec3& p) const {
    return cavity > 0 ? glm::length(p - dvec3(0.9, 0.3, 3.2 - cavity * 1e3)) - 1.0 : 1e3;
  }
  /// Depth below the enamel cap, mm.
  double below_cap(const dvec3& p) const { return -form(p) - std::clamp((p.z + 2.6) / 2.5, 0.0, 1.0) * 1.3; }
};

}  // namespace

std::vector<render::MeshUpdate> tooth_mesh(double cavity, double cell_m) {
  const double h = cell_m * 1e3;  // mm
  const Body body{cavity};
  const int n = static_cast<int>(std::ceil(6.5 / h)), low = static_cast<int>(std::ceil(10.0 / h));
  const ivec3 lo(-n, -n, -low), hi(n, n, n);
  const ivec3 size = hi - lo + 1;
  const auto at = [&](const ivec3& c) {
    const ivec3 r = c - lo;
    return static_cast<std::size_t>((r.z * size.y + r.y) * size.x + r.x);
  };
  std::vector<double> field(static_cast<std::size_t>(size.x) * size.y * size.z);
  for (int z = lo.z; z <= hi.z; ++z)
    for (int y = lo.y; y <= hi.y; ++y)
      for (int x = lo.x; x <= hi.x; ++x) field[at({x, y, z})] = body(dvec3(x, y, z) * h);

  // Makes a surface net: one vertex in each cell that the surface crosses, and one quad around each edge that it
  // crosses.
  const auto vertex = [&](const ivec3& c, bool decayed) {
    dvec3 sum(0);
    int crossings = 0;
    for (int a = 0; a < 8; ++a)
      for (int axis = 0; axis < 3; ++axis) {
        const int b = a | (1 << axis);
        if (b == a) continue;
        const auto corner = [&](int k) { return ivec3(k & 1, (k >> 1) & 1, k >> 2); };
        const double fa = field[at(c + corner(a))], fb = field[at(c + corner(b))];
        if ((fa < 0) == (fb < 0)) continue;
        sum += dvec3(corner(a)) + (dvec3(corner(b)) - dvec3(corner(a))) * (fa / (fa - fb));
        ++crossings;
      }
    const dvec3 p = (dvec3(c) + sum / static_cast<double>(std::max(crossings, 1))) * h;
    const double e = 0.05;
    const dvec3 g(body(p + dvec3(e, 0, 0)) - body(p - dvec3(e, 0, 0)),
                  body(p + dvec3(0, e, 0)) - body(p - dvec3(0, e, 0)),
                  body(p + dvec3(0, 0, e)) - body(p - dvec3(0, 0, e)));
    render::Vertex v;
    v.p = glm::vec3(p * 1e-3);
    v.n = glm::vec3(glm::normalize(g));
    // The boundary of the decay is where its fraction is one half.
    const dvec3 inside = p - glm::normalize(g) * 0.05;
    v.tissue = decayed ? std::array{Tissue::kDentin, Tissue::kCaries} : std::array{Tissue::kEnamel, Tissue::kDentin};
    v.second =
        static_cast<float>(std::clamp(0.5 + (decayed ? -body.lesion(inside) : body.below_cap(inside)), 0.0, 1.0));
    return v;
  };
  struct Less {
    bool operator()(const ivec3& a, const ivec3& b) const { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); }
  };
  struct Brick {
    render::MeshUpdate update;
    std::map<ivec3, std::uint32_t, Less> known[2];  // vertices of sound and of carious triangles
  };
  std::map<ivec3, Brick, Less> bricks;
  const int cells = std::max(static_cast<int>(3.0 / h), 4);
  for (int z = lo.z + 1; z < hi.z; ++z)
    for (int y = lo.y + 1; y < hi.y; ++y)
      for (int x = lo.x + 1; x < hi.x; ++x) {
        const ivec3 c(x, y, z);
        for (int axis = 0; axis < 3; ++axis) {
          ivec3 along(0), u(0), v(0);
          along[axis] = u[(axis + 1) % 3] = v[(axis + 2) % 3] = 1;
          const bool inside = field[at(c)] < 0;
          if (inside == (field[at(c + along)] < 0)) continue;
          const ivec3 key = glm::ivec3(glm::floor(dvec3(c) / static_cast<double>(cells)));
          Brick& brick = bricks[key];
          brick.update.brick = static_cast<std::uint64_t>(((key.x + 64) * 128 + key.y + 64) * 128 + key.z + 64);
          std::uint32_t quad[4];
          const ivec3 around[4] = {c - u - v, c - v, c, c - u};
          const bool decayed =
              body.lesion((dvec3(c) + 0.5 * dvec3(along)) * h) < 0.9 && body.below_cap(dvec3(c) * h) > 0;
          for (int k = 0; k < 4; ++k) {
            const auto [it, fresh] =
                brick.known[decayed].emplace(around[k], static_cast<std::uint32_t>(brick.update.vertices.size()));
            if (fresh) brick.update.vertices.push_back(vertex(around[k], decayed));
            quad[k] = it->second;
          }
          if (!inside) std::swap(quad[1], quad[3]);
          for (int k : {0, 1, 2, 0, 2, 3}) brick.update.indices.push_back(quad[k]);
        }
      }
  std::vector<render::MeshUpdate> updates;
  for (auto& [key, brick] : bricks) updates.push_back(std::move(brick.update));
  return updates;
}

render::MeshUpdate ball(std::uint64_t id, glm::vec3 center, float radius, Tissue tissue, int steps) {
  render::MeshUpdate u;
  u.brick = id;
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; j <= 2 * steps; ++j) {
      const double a = kPi * i / steps, b = kPi * j / steps;
      const glm::vec3 n(dvec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
      render::Vertex v;
      v.p = center + radius * n;
      v.n = n;
      v.tissue = {tissue, tissue};
      u.vertices.push_back(v);
    }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (2 * steps + 1) + j); };
  for (int i = 0; i < steps; ++i)
    for (int j = 0; j < 2 * steps; ++j)
      u.indices.insert(u.indices.end(),
                       {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)});
  return u;
}

}  // namespace typodont::test
