#include "haptics/tool.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "engine/base/units.h"

namespace typodont::haptics {

namespace {

using glm::dvec2;

constexpr std::array<std::pair<std::string_view, HeadShape>, 7> kShapes = {{
    {"sphere", HeadShape::kSphere},
    {"cylinder", HeadShape::kCylinder},
    {"round_end_cylinder", HeadShape::kRoundEndCylinder},
    {"cone", HeadShape::kCone},
    {"pear", HeadShape::kPear},
    {"flame", HeadShape::kFlame},
    {"inverted_cone", HeadShape::kInvertedCone},
}};

/// A convex meridian (ρ ≥ 0, z) as a chain of straight lines and arcs, from the free end to the shank end.
/// Every head is one: the distance to it in the half plane is the distance to the surface of revolution.
struct Piece {
  dvec2 a, b;            // end points
  dvec2 center{0, 0};    // of the arc
  double radius = 0;     // 0: a straight line
};

struct Meridian {
  std::array<Piece, 4> pieces;
  int count = 0;
  void line(dvec2 a, dvec2 b) { pieces[static_cast<std::size_t>(count++)] = {a, b, {}, 0}; }
  void arc(dvec2 a, dvec2 b, dvec2 center) {
    pieces[static_cast<std::size_t>(count++)] = {a, b, center, glm::length(a - center)};
  }
};

Meridian meridian(const Tool& tool) {
  const double r = tool.radius(), half = tool.length / 2;
  Meridian m;
  switch (tool.shape) {
    case HeadShape::kSphere:
      m.arc({0, -r}, {0, r}, {0, 0});
      break;
    case HeadShape::kCylinder:
      m.line({0, -half}, {r, -half});
      m.line({r, -half}, {r, half});
      m.line({r, half}, {0, half});
      break;
    case HeadShape::kRoundEndCylinder:  // a hemisphere at the free end, length over all
      m.arc({0, -half}, {r, -half + r}, {0, -half + r});
      m.line({r, -half + r}, {r, half});
      m.line({r, half}, {0, half});
      break;
    case HeadShape::kCone:  // pointed at the free end
      m.line({0, -half}, {r, half});
      m.line({r, half}, {0, half});
      break;
    case HeadShape::kInvertedCone: {  // wide at the free end, the neck half as wide
      m.line({0, -half}, {r, -half});
      m.line({r, -half}, {r / 2, half});
      m.line({r / 2, half}, {0, half});
      break;
    }
    case HeadShape::kPear: {  // a round free end of full width, tangent cone to a neck half as wide
      const dvec2 center(0, -half + r);
      const dvec2 neck(r / 2, half);
      // The tangent from the neck to the circle: the point where the radius meets the line at a right angle.
      const dvec2 d = neck - center;
      const double angle = std::atan2(d.x, d.y) + std::acos(std::min(1.0, r / glm::length(d)));
      const dvec2 touch = center + r * dvec2(std::sin(angle), std::cos(angle));
      m.arc({0, -half}, touch, center);
      m.line(touch, neck);
      m.line(neck, {0, half});
      break;
    }
    case HeadShape::kFlame: {  // a pointed arc through the widest place, a third of the way up, to a neck half as wide
      const double belly = -half + tool.length / 3;
      const double rise = belly + half;
      // One circle through the tip (0, -half) that is vertical at (r, belly): centre (r - R, belly).
      const double big = (r * r + rise * rise) / (2 * r);
      const dvec2 center(r - big, belly);
      m.arc({0, -half}, {r, belly}, center);
      m.line({r, belly}, {r / 2, half});
      m.line({r / 2, half}, {0, half});
      break;
    }
  }
  return m;
}

double distance_to_piece(const Piece& piece, const dvec2& q) {
  if (piece.radius == 0) {
    const dvec2 ab = piece.b - piece.a;
    const double s = std::clamp(glm::dot(q - piece.a, ab) / glm::dot(ab, ab), 0.0, 1.0);
    return glm::length(q - piece.a - s * ab);
  }
  // On the arc when the direction from the centre lies between its ends (arcs here turn from a to b, less than 180°,
  // counter-clockwise in (ρ, z)).
  const dvec2 d = q - piece.center;
  const dvec2 a = piece.a - piece.center, b = piece.b - piece.center;
  const auto cross = [](const dvec2& u, const dvec2& v) { return u.x * v.y - u.y * v.x; };
  if (cross(a, d) >= 0 && cross(d, b) >= 0) return std::abs(glm::length(d) - piece.radius);
  return std::min(glm::length(q - piece.a), glm::length(q - piece.b));
}

/// The half plane point is inside a convex meridian when it is on the inner side of every line and arc.
bool inside(const Meridian& m, const dvec2& q) {
  for (int i = 0; i < m.count; ++i) {
    const Piece& piece = m.pieces[static_cast<std::size_t>(i)];
    const dvec2 ab = piece.b - piece.a;
    const double side = ab.x * (q.y - piece.a.y) - ab.y * (q.x - piece.a.x);  // > 0: left of a→b, the inner side
    if (piece.radius == 0 ? side < 0 : (side < 0 && glm::length(q - piece.center) > piece.radius)) return false;
  }
  return true;
}

}  // namespace

double Tool::reach() const {
  if (shape == HeadShape::kSphere) return radius();
  return std::hypot(radius(), length / 2);
}

double Tool::distance(const dvec3& p) const {
  if (shape == HeadShape::kSphere) return glm::length(p) - radius();
  const dvec2 q(std::hypot(p.x, p.y), p.z);
  const Meridian m = meridian(*this);
  double d = 1e300;
  for (int i = 0; i < m.count; ++i) d = std::min(d, distance_to_piece(m.pieces[static_cast<std::size_t>(i)], q));
  return inside(m, q) ? -d : d;
}

double Tool::profile(double z) const {
  if (distance({0, 0, z}) >= 0) return 0;
  // The meridian is convex, so along ρ the distance changes sign once.
  double lo = 0, hi = radius() * (1 + 1e-9);
  for (int i = 0; i < 60; ++i) {
    const double mid = (lo + hi) / 2;
    (distance({mid, 0, z}) < 0 ? lo : hi) = mid;
  }
  return (lo + hi) / 2;
}

std::vector<HeadSample> sample_head(const Tool& tool, int count) {
  const double golden = kPi * (3 - std::sqrt(5.0));
  std::vector<HeadSample> samples;
  samples.reserve(static_cast<std::size_t>(count));
  if (tool.shape == HeadShape::kSphere) {  // Fibonacci sphere
    const double area = 4 * kPi * tool.radius() * tool.radius() / count;
    for (int i = 0; i < count; ++i) {
      const double z = 1 - (2.0 * i + 1) / count, rho = std::sqrt(1 - z * z);
      const dvec3 n(rho * std::cos(golden * i), rho * std::sin(golden * i), z);
      samples.push_back({n * tool.radius(), n, area});
    }
    return samples;
  }
  // Walk the meridian by area: the i-th sample sits at the (i + 1/2)/count quantile of 2πρ ds, at golden angles around.
  const Meridian m = meridian(tool);
  struct Step {
    dvec2 q;
    double area;
  };
  std::vector<Step> steps;
  double total = 0;
  for (int i = 0; i < m.count; ++i) {
    const Piece& piece = m.pieces[static_cast<std::size_t>(i)];
    constexpr int kFine = 512;
    for (int k = 0; k < kFine; ++k) {
      const auto at = [&](double s) {
        if (piece.radius == 0) return glm::mix(piece.a, piece.b, s);
        const dvec2 a = piece.a - piece.center, b = piece.b - piece.center;
        const double t0 = std::atan2(a.y, a.x);
        double t1 = std::atan2(b.y, b.x);
        if (t1 < t0) t1 += 2 * kPi;
        const double t = t0 + (t1 - t0) * s;
        return piece.center + piece.radius * dvec2(std::cos(t), std::sin(t));
      };
      const dvec2 q0 = at(k / static_cast<double>(kFine)), q1 = at((k + 1) / static_cast<double>(kFine));
      const dvec2 q = (q0 + q1) / 2.0;
      const double area = 2 * kPi * q.x * glm::length(q1 - q0);
      total += area;
      steps.push_back({q, area});
    }
  }
  double sum = 0;
  std::size_t step = 0;
  for (int i = 0; i < count; ++i) {
    const double wanted = total * (i + 0.5) / count;
    while (step + 1 < steps.size() && sum + steps[step].area < wanted) sum += steps[step++].area;
    const dvec2 q = steps[step].q;
    const dvec3 p(q.x * std::cos(golden * i), q.x * std::sin(golden * i), q.y);
    const double e = 1e-4 * tool.diameter;
    const dvec3 n = glm::normalize(dvec3(tool.distance(p + dvec3(e, 0, 0)) - tool.distance(p - dvec3(e, 0, 0)),
                                         tool.distance(p + dvec3(0, e, 0)) - tool.distance(p - dvec3(0, e, 0)),
                                         tool.distance(p + dvec3(0, 0, e)) - tool.distance(p - dvec3(0, 0, e))));
    samples.push_back({p, n, total / count});
  }
  return samples;
}

Tool read_tool(const Json& json) {
  json.allow_only({"name", "iso_6360", "shape", "diameter_mm", "length_mm", "cuts", "side_efficiency",
                   "end_efficiency", "cutting_coefficient", "source"});
  Tool tool;
  const std::string shape = json["shape"].string();
  const auto it = std::find_if(kShapes.begin(), kShapes.end(), [&](const auto& s) { return s.first == shape; });
  if (it == kShapes.end()) {
    json["shape"].fail("sphere, cylinder, round_end_cylinder, cone, pear, flame or inverted_cone");
  }
  tool.shape = it->second;
  tool.name = json.string_or("name", shape);
  tool.iso_code = json.string_or("iso_6360", "");
  tool.diameter = json["diameter_mm"].number(0.05, 60) * kMillimetre;
  if (tool.shape == HeadShape::kSphere) {
    tool.length = json.number_or("length_mm", tool.diameter / kMillimetre) * kMillimetre;
    if (std::abs(tool.length - tool.diameter) > 1e-9) json["length_mm"].fail("the diameter, or no length, for a sphere");
  } else {
    tool.length = json["length_mm"].number(0.05, 60) * kMillimetre;
    const bool rounded = tool.shape == HeadShape::kRoundEndCylinder || tool.shape == HeadShape::kPear;
    if (rounded && tool.length < tool.diameter) json["length_mm"].fail("at least the diameter");
    if (tool.shape == HeadShape::kFlame && tool.length < 1.5 * tool.diameter) {
      json["length_mm"].fail("at least 1.5 times the diameter");
    }
  }
  tool.cuts = json.boolean_or("cuts", true);
  tool.side_efficiency = json.number_or("side_efficiency", 1, 0, 1);
  tool.end_efficiency = json.number_or("end_efficiency", 1, 0, 1);
  tool.cutting_coefficient = json.number_or("cutting_coefficient", 0.3, 0, 10);
  return tool;
}

}  // namespace typodont::haptics
