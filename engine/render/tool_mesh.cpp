#include "engine/render/tool_mesh.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"

namespace typodont::render {

namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kMark = 0.4e-3;          // m, height of a depth mark's ring
constexpr double kMarkEdge = 0.01e-3;     // m, width of the soft edge of a depth mark
constexpr int kRingsPerTurn = 10;         // number of rings per turn of a thread
constexpr int kFluteRings = 16;           // number of rings along a fluted head
constexpr double kCrease = 30 * kDegree;  // rad; at a larger angle of the outline, the head has an edge
constexpr double kChord = 1e-6;           // m, largest distance of a mesh edge from the circle that it approximates
constexpr double kCoarsest = 5e-4;        // for large heads, this fraction of the radius is used instead of kChord

/// Number of corners of a ring: a multiple of 24, so that 2, 6, 8 or 12 flutes have equal numbers of corners.
int corners_around(double radius) {
  return 24 * static_cast<int>(std::ceil(kPi / std::acos(1 - std::max(kChord / radius, kCoarsest)) / 24));
}

/// Adds rings along a profile. cut(profile radius, z, angle) returns the radius of the surface with flutes; marked(z)
/// returns true if the surface is dark at z.
template <class Cut, class Marked>
void add_lathe(ToolMesh& mesh, const std::vector<dvec2>& profile, int around_count, float rough, Finish finish,
               Cut&& cut, Marked&& marked) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto point = [&](std::size_t ring, int corner, bool fluted) {
    const double angle = 2 * kPi * corner / around_count;
    const dvec2 p = profile[ring];
    const double r = fluted ? cut(p.x, p.y, angle) : p.x;
    return dvec3(r * std::cos(angle), r * std::sin(angle), p.y);
  };
  const auto normal = [&](std::size_t ring, int corner, bool fluted) {
    const std::size_t below = ring ? ring - 1 : ring, above = std::min(ring + 1, profile.size() - 1);
    const dvec3 along = point(above, corner, fluted) - point(below, corner, fluted);
    const double angle = 2 * kPi * corner / around_count;
    dvec3 around = point(ring, corner + 1, fluted) - point(ring, corner - 1, fluted);
    if (glm::length(around) < 1e-9) around = dvec3(-std::sin(angle), std::cos(angle), 0);
    const dvec3 n = glm::cross(around, along);
    const double length = glm::length(n);
    return length > 1e-18 ? n / length : dvec3(0, 0, ring ? 1 : -1);
  };
  for (std::size_t ring = 0; ring < profile.size(); ++ring)
    for (int corner = 0; corner < around_count; ++corner)
      mesh.vertices.push_back({glm::vec3(point(ring, corner, true)), glm::vec3(normal(ring, corner, true)),
                               glm::vec3(point(ring, corner, false)), glm::vec3(normal(ring, corner, false)), 1.0f,
                               rough, marked(profile[ring].y) ? 1.0f : 0.0f, static_cast<float>(finish)});
  for (std::size_t ring = 0; ring + 1 < profile.size(); ++ring)
    for (int corner = 0; corner < around_count; ++corner) {
      const auto a = first + static_cast<std::uint32_t>(ring * around_count + corner);
      const auto b = first + static_cast<std::uint32_t>(ring * around_count + (corner + 1) % around_count);
      mesh.indices.insert(mesh.indices.end(), {a, b, b + around_count, a, b + around_count, a + around_count});
    }
}

/// Outline of the head, with additional rings for depth marks, flutes and thread.
std::vector<dvec2> refined(const ToolShape& shape) {
  const auto& p = shape.head;
  std::vector<double> more;
  for (const double mark : shape.marks) {
    for (const double side : {-1.0, 1.0}) {
      more.push_back(mark + side * (kMark / 2 + kMarkEdge));
      more.push_back(mark + side * (kMark / 2 - kMarkEdge));
    }
  }
  const auto add_every = [&](double step, double from, double to) {
    for (double z = from; z < to; z += step) more.push_back(z);
  };
  if (shape.thread_pitch > 0) add_every(shape.thread_pitch / kRingsPerTurn, p.front().y, p.back().y);
  if (const double step = (p.back().y - p.front().y) / kFluteRings; shape.flutes > 0)
    for (std::size_t i = 1; i < p.size(); ++i)
      if (p[i].y - p[i - 1].y > step) add_every(step, p[i - 1].y, p[i].y);
  std::sort(more.begin(), more.end());
  std::vector<dvec2> out{p.front()};
  for (std::size_t i = 1; i < p.size(); ++i) {
    const dvec2 a = p[i - 1], b = p[i];
    for (const double z : more) {
      if (!(z > a.y + kMarkEdge && z < b.y - kMarkEdge)) continue;
      out.push_back({a.x + (b.x - a.x) * (z - a.y) / (b.y - a.y), z});
    }
    out.push_back(b);
  }
  return out;
}

/// Divides an outline at its sharp corners into smooth parts.
std::vector<std::vector<dvec2>> smooth_parts(const std::vector<dvec2>& outline) {
  std::vector<std::vector<dvec2>> parts;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    if (parts.empty()) parts.emplace_back();
    parts.back().push_back(outline[i]);
    if (i == 0 || i + 1 == outline.size()) continue;
    const dvec2 a = glm::normalize(outline[i] - outline[i - 1]), b = glm::normalize(outline[i + 1] - outline[i]);
    if (glm::dot(a, b) < std::cos(kCrease)) parts.push_back({outline[i]});
  }
  return parts;
}

}  // namespace

void add_lathe(ToolMesh& mesh, const std::vector<dvec2>& profile, int around, float rough) {
  add_lathe(
      mesh, profile, around, rough, Finish::kBrushed, [](double r, double, double) { return r; },
      [](double) { return false; });
}

ToolMesh make_suction_mesh(double opening, double wall, double slant, double length) {
  const double inner = opening / 2, outer = inner + wall, depth = 4 * opening, slope = std::tan(slant);
  const double ends = outer * slope + opening;  // m; vertices below this z are shifted to form the slanted opening
  ToolMesh mesh;
  // Inner surface: from the dark bottom in the tube to the rounded rim. The outer surface follows.
  add_lathe(mesh, {{0, depth}, {inner, depth}, {inner, ends}, {inner, 0.3 * wall}, {inner + 0.2 * wall, 0}}, 48, 0.9f);
  for (ToolVertex& v : mesh.vertices) v.mark = 1;
  add_lathe(mesh,
            {{inner + 0.2 * wall, 0},
             {outer - 0.2 * wall, 0},
             {outer, 0.3 * wall},
             {outer, ends},
             {outer, length},
             {0, length}},
            48, 0.35f);
  for (ToolVertex& v : mesh.vertices) {
    const double z = v.p.z, lift = z < ends ? slope * static_cast<double>(v.p.x) * (1 - z / ends) : 0;
    v.p.z = v.hull_p.z = static_cast<float>(z + lift);
    v.spins = 0;
  }
  return mesh;
}

ToolMesh make_tool_mesh(const ToolShape& shape) {
  ToolMesh mesh;
  mesh.blades = shape.flutes > 0 ? shape.flutes : 1;
  double widest = 0;
  for (const auto* outline : {&shape.head, &shape.safe_end, &shape.shaft})
    for (const dvec2& p : *outline) widest = std::max(widest, p.x);
  const int around = corners_around(widest);
  constexpr float kSteelRough = 0.22f, kPolishedRough = 0.24f, kGritRough = 0.75f;
  const auto add_smooth = [&](const std::vector<dvec2>& outline) {
    for (const auto& part : smooth_parts(outline)) add_lathe(mesh, part, around, kSteelRough);
  };
  add_smooth(shape.safe_end);
  add_smooth(shape.shaft);
  if (shape.head.empty()) return mesh;

  const std::vector<dvec2> head = refined(shape);
  const double z0 = head.front().y, z1 = head.back().y, span = std::max(z1 - z0, 1e-6);
  // Radius of a head with flutes or thread. Flutes form a saw tooth around the axis (steep,
  // then gradual) that turns along a helix; only their cutting edges touch the outline.
  const auto cut = [&](double r, double z, double angle) {
    if (shape.thread_pitch > 0) {
      // Right-handed thread: turning clockwise, seen from the shank, screws it in. Its grooves fade at both ends.
      double phase = z / shape.thread_pitch - angle / (2 * kPi);
      phase -= std::floor(phase);
      const double groove = std::abs(2 * phase - 1);
      const double fade = std::clamp(std::min(z - z0, z1 - z) / shape.thread_pitch, 0.0, 1.0);
      return std::max(std::min(r, shape.thread_core), r - (r - shape.thread_core) * groove * fade);
    }
    if (!(shape.flutes > 0)) return r;
    double phase = (angle / (2 * kPi) + shape.helix * (z - z0) / span) * shape.flutes;
    phase -= std::floor(phase);
    // Depth of the groove: 0 at the cutting edge, 1 at the bottom.
    const double groove = phase < 0.2 ? phase / 0.2 : 1 - (phase - 0.2) / 0.8;
    const double fade = std::clamp((z1 - z) / (0.15 * span), 0.0, 1.0);
    return r * (1 - shape.flute_depth * groove * fade);
  };
  for (const auto& part : smooth_parts(head))
    add_lathe(mesh, part, around, shape.diamond ? kGritRough : kPolishedRough,
              shape.diamond ? Finish::kGrit : Finish::kPolished, cut, [&](double z) {
                return std::any_of(shape.marks.begin(), shape.marks.end(),
                                   [&](double mark) { return std::abs(z - mark) < kMark / 2; });
              });
  return mesh;
}

}  // namespace typodont::render
