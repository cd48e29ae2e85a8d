#include "engine/render/tool_mesh.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::render {

namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kMark = 0.4e-3;       // m, height of a depth mark's ring
constexpr double kMarkEdge = 0.01e-3;  // m, height of the soft edge of a depth mark's ring
constexpr int kRingsPerTurn = 10;      // number of rings of mesh vertices per turn of a thread
// number of mesh corners around the tool's axis; kHeadAround is divisible by the usual numbers of flutes: 6, 8 and 12
constexpr int kHeadAround = 72, kShaftAround = 36;

/// Adds points of a circular arc about (0, z0), from angle a to angle b. Angles are measured from the direction −z.
void add_arc(std::vector<dvec2>& profile, double radius, double z0, double a, double b, int steps) {
  for (int i = 0; i <= steps; ++i) {
    const double t = a + (b - a) * i / steps;
    profile.push_back({radius * std::sin(t), z0 - radius * std::cos(t)});
  }
}

/// Adds a surface of revolution: rings of corners along a profile. `cut` returns the radius of the surface with flutes,
/// for the profile's radius, z and an angle. `marked` returns true if a ring at z is dark.
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

constexpr std::array<std::string_view, 7> kOwnLooks = {"sphere", "cylinder", "round_end_cylinder", "cone",
                                                       "pear",   "flame",    "inverted_cone"};

/// Returns the length (m) of the neck behind a head of radius r.
double neck_behind(double r) {
  return std::max(std::min(0.45 * r, 5e-4), std::min(0.8 * r, 2.0e-4));
}

/// Returns the head's profile with additional rings for depth marks and thread.
std::vector<dvec2> refined(const ToolShape& shape) {
  if (shape.marks.empty() && !(shape.thread_pitch > 0)) return shape.profile;
  std::vector<double> more;
  for (const double mark : shape.marks) {
    for (const double side : {-1.0, 1.0}) {
      more.push_back(mark + side * (kMark / 2 + kMarkEdge));
      more.push_back(mark + side * (kMark / 2 - kMarkEdge));
    }
  }
  const auto& p = shape.profile;
  if (shape.thread_pitch > 0) {
    for (double z = p.front().y; z < p.back().y; z += shape.thread_pitch / kRingsPerTurn) more.push_back(z);
  }
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

}  // namespace

bool has_own_look(std::string_view shape) noexcept {
  return std::find(kOwnLooks.begin(), kOwnLooks.end(), shape) != kOwnLooks.end();
}

ToolShape outlined_shape(std::vector<dvec2> outline) {
  ToolShape tool;
  tool.profile = std::move(outline);
  double r = 0;
  for (const dvec2& p : tool.profile) r = std::max(r, p.x);
  tool.neck_radius = neck_behind(r);
  tool.profile.push_back({tool.neck_radius, tool.profile.back().y + 0.2 * r});
  return tool;
}

ToolShape tool_shape(std::string_view shape, double diameter, double length) {
  ToolShape tool;
  const double r = diameter / 2, h = length / 2;
  auto& p = tool.profile;
  tool.neck_radius = neck_behind(r);
  const double neck_angle = kPi - std::asin(std::min(1.0, tool.neck_radius / r));
  if (shape == "sphere") {
    add_arc(p, r, 0, 0, neck_angle, 28);
  } else if (shape == "cylinder") {
    p = {{0, -h}, {0.96 * r, -h}, {r, -h + 0.04 * r}};
    for (int i = 1; i < 12; ++i) p.push_back({r, -h + length * i / 12});
    p.insert(p.end(), {{r, h}, {tool.neck_radius, h + 0.2 * r}});
  } else if (shape == "round_end_cylinder") {
    add_arc(p, r, -h + r, 0, kPi / 2, 12);
    for (int i = 1; i < 12; ++i) p.push_back({r, -h + r + (length - r) * i / 12});
    p.insert(p.end(), {{r, h}, {tool.neck_radius, h + 0.2 * r}});
  } else if (shape == "cone") {
    p = {{0, -h}};
    for (int i = 1; i <= 16; ++i) p.push_back({r * i / 16, -h + length * i / 16});
    p.push_back({tool.neck_radius, h + 0.2 * r});
  } else if (shape == "inverted_cone") {
    p = {{0, -h}, {0.96 * r, -h}, {r, -h + 0.04 * r}};
    const double top = std::max(0.6 * r, tool.neck_radius);
    for (int i = 1; i <= 12; ++i) p.push_back({r + (top - r) * i / 12, -h + 0.04 * r + (length - 0.04 * r) * i / 12});
    p.push_back({tool.neck_radius, h + 0.1 * r});
  } else if (shape == "pear") {
    add_arc(p, r, -h + r, 0, kPi / 2, 14);
    const double top = std::max(0.55 * r, tool.neck_radius);
    for (int i = 1; i <= 14; ++i) {
      const double s = i / 14.0;
      p.push_back({r + (top - r) * s * s * (3 - 2 * s), -h + r + (length - r) * s});
    }
    p.push_back({tool.neck_radius, h + 0.3 * r});
  } else if (shape == "flame") {
    for (int i = 0; i <= 24; ++i) {
      // fraction of the head's length; a flame's radius grows from 0 to its maximum at s = 0.6 and then decreases
      const double s = i / 24.0;
      const double w = s < 0.6 ? std::sin(kPi / 2 * s / 0.6) : std::cos(0.75 * (s - 0.6) / 0.4);
      p.push_back({r * w, -h + length * s});
    }
    p.push_back({std::min(tool.neck_radius, p.back().x), h + 0.3 * r});
    tool.diamond = true;
    tool.flutes = 0;
  } else {
    throw Error("", "tool shape", fmt::format("\"{}\"", shape), fmt::format("one of {}", fmt::join(kOwnLooks, ", ")));
  }
  return tool;
}

void add_lathe(ToolMesh& mesh, const std::vector<dvec2>& profile, int around, float rough) {
  add_lathe(
      mesh, profile, around, rough, Finish::kBrushed, [](double r, double, double) { return r; },
      [](double) { return false; });
}

ToolMesh make_suction_mesh(double opening, double wall, double slant, double length) {
  const double inner = opening / 2, outer = inner + wall, depth = 4 * opening, slope = std::tan(slant);
  const double ends = outer * slope + opening;  // m, z at which the slanted opening of the suction tip ends
  ToolMesh mesh;
  // The suction tip's profile begins at the dark bottom in the tube, goes down to the rounded rim, then up the outside.
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
  const std::vector<dvec2> head = refined(shape);
  const double z0 = head.front().y, z1 = head.back().y, span = std::max(z1 - z0, 1e-6);
  const double widest = std::max_element(head.begin(), head.end(), [](auto& a, auto& b) { return a.x < b.x; })->x;

  mesh.blades = shape.flutes > 0 ? shape.flutes : 1;

  // Head of a bur: the profile of a blade rises steeply at its cutting edge and falls slowly behind it, like a saw
  // tooth. The blades run along a helix.
  const auto cut = [&](double r, double z, double angle) {
    if (shape.thread_pitch > 0) {
      // A sharp right-handed thread: a clockwise rotation, as seen from the shank, screws the thread in. The thread
      // fades at both ends.
      double phase = z / shape.thread_pitch - angle / (2 * kPi);
      phase -= std::floor(phase);
      const double groove = std::abs(2 * phase - 1);
      const double fade = std::clamp(std::min(z - z0, z1 - z) / shape.thread_pitch, 0.0, 1.0);
      return std::max(std::min(r, shape.thread_core), r - (r - shape.thread_core) * groove * fade);
    }
    if (shape.flutes > 0) {
      double phase = (angle / (2 * kPi) + shape.helix * (z - z0) / span) * shape.flutes;
      phase -= std::floor(phase);
      // depth in the profile of a flute: 0 at the cutting edge of a blade, 1 at the bottom of the groove
      const double groove = phase < 0.2 ? phase / 0.2 : 1 - (phase - 0.2) / 0.8;
      const double fade = std::clamp((z1 - z) / (0.15 * span), 0.0, 1.0);
      return r * (1 - shape.flute_depth * groove * fade);
    }
    if (!shape.diamond) return r;
    // Diamond grit: bumps in a fixed pattern that is the same in every run.
    const double g = std::sin(37.0 * angle + 5100.0 * z / widest * 1e-3) * std::sin(41.0 * z / widest + 3.0 * angle);
    return r * (1 - 0.035 * (0.5 + 0.5 * g));
  };
  add_lathe(mesh, head, kHeadAround, shape.diamond ? 0.75f : 0.24f, shape.diamond ? Finish::kGrit : Finish::kPolished,
            cut, [&](double z) {
              return std::any_of(shape.marks.begin(), shape.marks.end(),
                                 [&](double mark) { return std::abs(z - mark) < kMark / 2; });
            });

  if (!(shape.shank_length > 0)) {  // a handle replaces neck and shank of the tool
    add_lathe(mesh, {{head.back().x, z1}, {0, z1}}, kHeadAround, 0.22f);
    return mesh;
  }
  // Neck and shank: a smooth taper, then the friction-grip cylinder with a rounded end.
  std::vector<dvec2> shaft{{head.back().x, z1}};
  for (int i = 1; i <= 10; ++i) {
    const double s = i / 10.0, blend = s * s * (3 - 2 * s);
    shaft.push_back(
        {shape.neck_radius + (shape.shank_radius - shape.neck_radius) * blend * blend, z1 + shape.neck_length * s});
  }
  const double end = z1 + shape.neck_length + shape.shank_length;
  shaft.insert(shaft.end(), {{shape.shank_radius, end - 0.2e-3}, {0.8 * shape.shank_radius, end}, {0, end}});
  add_lathe(mesh, shaft, kShaftAround, 0.22f);
  return mesh;
}

}  // namespace typodont::render
