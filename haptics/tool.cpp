#include "haptics/tool.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "haptics/described.h"
#include "haptics/solid.h"

namespace typodont::haptics {

namespace {

using glm::dvec2;

constexpr Form kLength{"0.05–60", R"({"type": "number", "minimum": 0.05, "maximum": 60})"};

// Height above the free end, divided by the head's diameter. Up to this height, the samples on the head's surface are
// equally dense; above it, they are less dense.
constexpr double kBluntEnd = 0.1;

/// Piece of a meridian. A meridian is a convex chain of lines and arcs in (ρ ≥ 0, z) from the free end to the shank
/// end. The distance to the chain is the distance to the surface.
struct Piece {
  dvec2 a, b;          // end points of the piece
  dvec2 center{0, 0};  // centre of the arc
  double radius = 0;   // radius of the arc; 0: a straight line
};

struct Meridian {
  std::array<Piece, 4> pieces;
  int count = 0;
  Meridian& lines(std::initializer_list<dvec2> points) {
    for (const dvec2* p = points.begin(); p + 1 != points.end(); ++p)
      pieces[static_cast<std::size_t>(count++)] = {p[0], p[1], {}, 0};
    return *this;
  }
  Meridian& arc(dvec2 a, dvec2 b, dvec2 center) {
    pieces[static_cast<std::size_t>(count++)] = {a, b, center, glm::length(a - center)};
    return *this;
  }
};

HeadField::Piece scaled(const Piece& piece, double unit) {
  const dvec2 a = piece.a / unit, b = piece.b / unit, d = b - a, c = piece.center / unit;
  return {a.x, a.y, b.x, b.y, d.x, d.y, 1 / glm::dot(d, d), c.x, c.y, piece.radius / unit};
}

// Meridians of the shapes, from the free end to the shank end.

Meridian sphere(const Tool& tool) {
  const double r = tool.radius();
  return Meridian().arc({0, -r}, {0, r}, {0, 0});
}

Meridian cylinder(const Tool& tool) {
  const double r = tool.radius(), half = tool.length / 2;
  return Meridian().lines({{0, -half}, {r, -half}, {r, half}, {0, half}});
}

/// Cylinder with a hemisphere at the free end; `length` includes the hemisphere.
Meridian round_end_cylinder(const Tool& tool) {
  const double r = tool.radius(), half = tool.length / 2;
  return Meridian().arc({0, -half}, {r, -half + r}, {0, -half + r}).lines({{r, -half + r}, {r, half}, {0, half}});
}

/// Cone with its tip at the free end.
Meridian cone(const Tool& tool) {
  const double r = tool.radius(), half = tool.length / 2;
  return Meridian().lines({{0, -half}, {r, half}, {0, half}});
}

/// Hemisphere of full width, then a tangent cone to a neck of half the width.
Meridian pear(const Tool& tool) {
  const double r = tool.radius(), half = tool.length / 2;
  const dvec2 center(0, -half + r);
  const dvec2 neck(r / 2, half);
  // Where the cone touches the hemisphere, the hemisphere's radius is perpendicular to the cone's line.
  const dvec2 d = neck - center;
  const double angle = std::atan2(d.x, d.y) + std::acos(std::min(1.0, r / glm::length(d)));
  const dvec2 touch = center + r * dvec2(std::sin(angle), std::cos(angle));
  return Meridian().arc({0, -half}, touch, center).lines({touch, neck, {0, half}});
}

/// Arc from the tip to the largest diameter at a third of the length, then a cone to a neck of half the width.
Meridian flame(const Tool& tool) {
  const double r = tool.radius(), half = tool.length / 2;
  const double belly = -half + tool.length / 3;
  const double rise = belly + half;
  // The arc of radius R passes through the tip (0, -half) and is vertical at (r, belly), so its centre is (r - R,
  // belly).
  const double big = (r * r + rise * rise) / (2 * r);
  const dvec2 center(r - big, belly);
  return Meridian().arc({0, -half}, {r, belly}, center).lines({{r, belly}, {r / 2, half}, {0, half}});
}

/// Cone that is widest at the free end, with a neck of half the width.
Meridian inverted_cone(const Tool& tool) {
  const double r = tool.radius(), half = tool.length / 2;
  return Meridian().lines({{0, -half}, {r, -half}, {r / 2, half}, {0, half}});
}

/// Meridian of a shank that widens from its neck to the full diameter.
Meridian shaft(const Tool& tool) {
  const double r = tool.radius(), half = tool.length / 2;
  const double neck = tool.neck_diameter / 2, taper = -half + tool.neck_length;
  if (tool.neck_length < tool.length)
    return Meridian().lines({{0, -half}, {neck, -half}, {r, taper}, {r, half}, {0, half}});
  return Meridian().lines({{0, -half}, {neck, -half}, {r, half}, {0, half}});
}

/// The properties of a shape in scenes.
struct ShapeKind {
  HeadShape shape;
  std::string_view name;  // name of the shape in scenes
  Meridian (*meridian)(const Tool&);
  double min_length;  // lower limit of the length divided by the diameter; 0: no limit
};
constexpr std::array kShapes = {
    ShapeKind{HeadShape::kSphere, "sphere", sphere, 1},
    ShapeKind{HeadShape::kCylinder, "cylinder", cylinder, 0},
    ShapeKind{HeadShape::kRoundEndCylinder, "round_end_cylinder", round_end_cylinder, 1},
    ShapeKind{HeadShape::kCone, "cone", cone, 0},
    ShapeKind{HeadShape::kPear, "pear", pear, 1},
    ShapeKind{HeadShape::kFlame, "flame", flame, 1.5},
    ShapeKind{HeadShape::kInvertedCone, "inverted_cone", inverted_cone, 0},
};

/// Returns the properties of a shape; null for a shaft.
const ShapeKind* kind_of(HeadShape shape) {
  const auto row = std::find_if(kShapes.begin(), kShapes.end(), [&](const ShapeKind& s) { return s.shape == shape; });
  return row == kShapes.end() ? nullptr : &*row;
}

Meridian meridian(const Tool& tool) {
  const ShapeKind* kind = kind_of(tool.shape);
  return kind ? kind->meridian(tool) : shaft(tool);
}

/// Names of the shapes, in the order of HeadShape.
constexpr auto kShapeNames = [] {
  std::array<std::string_view, kShapes.size()> names;
  for (const ShapeKind& kind : kShapes) names[static_cast<std::size_t>(kind.shape)] = kind.name;
  return names;
}();

}  // namespace

std::string_view name_of(HeadShape shape) noexcept {
  const ShapeKind* kind = kind_of(shape);
  return kind ? kind->name : "cylinder";
}

double Tool::reach() const {
  if (shape == HeadShape::kSphere) return radius();
  return std::hypot(radius(), length / 2);
}

std::optional<NonCuttingPart> shank_of(const Tool& tool) {
  if (!(tool.shank_length > 0)) return std::nullopt;
  Tool shape;
  shape.name = "shank";
  shape.shape = HeadShape::kShaft;
  shape.cuts = false;
  shape.diameter = tool.shank_diameter;
  shape.neck_diameter = tool.neck_diameter;
  shape.length = tool.shank_length;
  shape.neck_length = std::min(tool.neck_length, tool.shank_length);
  // On a ball, the shank begins at the height where the ball is as wide as the shank's neck.
  const double neck = tool.neck_diameter / 2;
  const double from = tool.shape == HeadShape::kSphere
                          ? std::sqrt(std::max(tool.radius() * tool.radius() - neck * neck, 0.0))
                          : tool.half();
  return NonCuttingPart{shape, from + shape.length / 2};
}

std::optional<NonCuttingPart> safe_end_of(const Tool& tool) {
  if (!(tool.safe_length > 0)) return std::nullopt;
  Tool shape;
  shape.name = "safe end";
  shape.shape = HeadShape::kRoundEndCylinder;
  shape.cuts = false;
  shape.diameter = tool.safe_diameter;
  shape.length = std::max(tool.safe_length, tool.safe_diameter);  // the safe end's upper part is inside the head
  return NonCuttingPart{shape, -tool.half() - tool.safe_length + shape.length / 2};
}

double near_reach(const Tool& tool) {
  return std::max(tool.reach(), tool.safe_length > 0 ? tool.half() + tool.safe_length : 0.0);
}

double Tool::distance(const dvec3& p) const {
  if (shape == HeadShape::kSphere) return glm::length(p) - radius();
  return HeadField(*this, 1.0).distance(p);
}

HeadField::HeadField(const Tool& tool, double unit) {
  const Meridian m = meridian(tool);
  for (int i = 0; i < m.count; ++i) pieces[count++] = scaled(m.pieces[static_cast<std::size_t>(i)], unit);
}

HeadField HeadField::with_exit_path(const Tool& tool, double unit) {
  const Meridian m = meridian(tool);
  HeadField field;
  for (auto piece : m.pieces) {
    if (piece.radius > 0 && piece.b.y > piece.center.y) piece.b = piece.center + dvec2(piece.radius, 0);
    field.pieces[field.count++] = scaled(piece, unit);
    if (piece.b.x < tool.radius() * (1 - 1e-9)) continue;
    field.pieces[field.count++] = scaled({piece.b, piece.b + dvec2(0, 1)}, unit);
    break;
  }
  return field;
}

/// Returns the signed distance of the point (rho, z) of the half plane. `n_rho`, `n_z`: unit direction in which it
/// increases.
double HeadField::nearest(double rho, double z, double& n_rho, double& n_z) const noexcept {
  // Squared distance to the closest point, and vector from there to the query point.
  double best2 = 1e300, best_x = 0, best_z = 0;
  // Normal of the closest piece; needed only for points on the surface.
  double normal_x = 0, normal_z = 0;
  bool outside = false;
  for (int i = 0; i < count; ++i) {
    const Piece& piece = pieces[i];
    const double ex = rho - piece.ax, ez = z - piece.az;
    const double side = piece.dx * ez - piece.dz * ex;  // positive inside: the point is left of the direction a→b
    double fx, fz, nx, nz;
    if (piece.radius == 0) {
      const double s = std::clamp((ex * piece.dx + ez * piece.dz) * piece.inverse2, 0.0, 1.0);
      fx = ex - s * piece.dx, fz = ez - s * piece.dz;
      nx = piece.dz, nz = -piece.dx;
      outside |= side < 0;
    } else {
      // The closest point lies on the arc itself if the direction from its centre is between the directions to its ends
      // (counter-clockwise in (ρ, z), less than 180°).
      const double vx = rho - piece.cx, vz = z - piece.cz, length = std::sqrt(vx * vx + vz * vz);
      const double ux = piece.ax - piece.cx, uz = piece.az - piece.cz, wx = piece.bx - piece.cx,
                   wz = piece.bz - piece.cz;
      outside |= side <= 0 && length > piece.radius;
      if (length > 0 && ux * vz - uz * vx >= 0 && vx * wz - vz * wx >= 0) {
        const double f = 1 - piece.radius / length;
        fx = vx * f, fz = vz * f;
      } else {
        const double gx = rho - piece.bx, gz = z - piece.bz;
        const bool first = ex * ex + ez * ez < gx * gx + gz * gz;
        fx = first ? ex : gx, fz = first ? ez : gz;
      }
      nx = vx, nz = vz;
    }
    const double f2 = fx * fx + fz * fz;
    if (f2 < best2) best2 = f2, best_x = fx, best_z = fz, normal_x = nx, normal_z = nz;
  }
  const double length = std::sqrt(best2), sign = outside ? 1 : -1;
  if (length > 1e-9) {
    n_rho = sign * best_x / length, n_z = sign * best_z / length;
  } else {
    const double normal_length = std::sqrt(normal_x * normal_x + normal_z * normal_z);
    n_rho = normal_length > 0 ? normal_x / normal_length : 1, n_z = normal_length > 0 ? normal_z / normal_length : 0;
  }
  return sign * length;
}

double HeadField::distance(const dvec3& p) const noexcept {
  double n_rho, n_z;
  return nearest(std::sqrt(p.x * p.x + p.y * p.y), p.z, n_rho, n_z);
}

double HeadField::distance(const dvec3& p, double (&to_piece)[4]) const noexcept {
  static_assert(kMaxPieces == 4);
  const double rho = std::sqrt(p.x * p.x + p.y * p.y), z = p.z;
  double best = 1e300;
  bool outside = false;
  for (int i = 0; i < count; ++i) {
    const Piece& piece = pieces[i];
    const double ex = rho - piece.ax, ez = z - piece.az;
    const double side = piece.dx * ez - piece.dz * ex;
    double d;
    if (piece.radius == 0) {
      const double s = std::clamp((ex * piece.dx + ez * piece.dz) * piece.inverse2, 0.0, 1.0);
      const double fx = ex - s * piece.dx, fz = ez - s * piece.dz;
      d = std::sqrt(fx * fx + fz * fz);
      outside |= side < 0;
    } else {
      const double vx = rho - piece.cx, vz = z - piece.cz, length = std::sqrt(vx * vx + vz * vz);
      const double ux = piece.ax - piece.cx, uz = piece.az - piece.cz, wx = piece.bx - piece.cx,
                   wz = piece.bz - piece.cz;
      const double gx = rho - piece.bx, gz = z - piece.bz;
      d = ux * vz - uz * vx >= 0 && vx * wz - vz * wx >= 0 ? std::abs(length - piece.radius)
                                                           : std::sqrt(std::min(ex * ex + ez * ez, gx * gx + gz * gz));
      outside |= side <= 0 && length > piece.radius;
    }
    to_piece[i] = d;
    best = std::min(best, d);
  }
  return outside ? best : -best;
}

double HeadField::distance(const dvec3& p, dvec3& n_T) const noexcept {
  const double rho = std::sqrt(p.x * p.x + p.y * p.y);
  double n_rho, n_z;
  const double d = nearest(rho, p.z, n_rho, n_z);
  n_T = rho > 1e-12 ? dvec3(n_rho * p.x / rho, n_rho * p.y / rho, n_z) : dvec3(n_rho, 0, n_z);
  return d;
}

double Tool::area() const {
  const Meridian m = meridian(*this);
  double sum = 0;
  for (int i = 0; i < m.count; ++i) {
    const auto& [a, b, center, radius] = m.pieces[static_cast<std::size_t>(i)];
    if (radius == 0) {
      sum += kPi * (a.x + b.x) * glm::length(b - a);
    } else {  // ∫ 2π (c + r cos θ) r dθ
      const double turn = std::atan2(b.y - center.y, b.x - center.x) - std::atan2(a.y - center.y, a.x - center.x);
      sum += 2 * kPi * radius * (center.x * (turn < 0 ? turn + 2 * kPi : turn) + b.y - a.y);
    }
  }
  return sum;
}

double Tool::profile(double z) const {
  if (distance({0, 0, z}) >= 0) return 0;
  // Bisection of the radius ρ: the head is convex, so the sign of the distance changes only once.
  double lo = 0, hi = radius() * (1 + 1e-9);
  for (int i = 0; i < 60; ++i) {
    const double mid = (lo + hi) / 2;
    (distance({mid, 0, z}) < 0 ? lo : hi) = mid;
  }
  return (lo + hi) / 2;
}

std::vector<HeadSample> sample_head(const Tool& tool, int count, double near_end) {
  const double golden = kPi * (3 - std::sqrt(5.0));
  std::vector<HeadSample> samples;
  samples.reserve(static_cast<std::size_t>(count));
  if (tool.shape == HeadShape::kSphere) {  // a Fibonacci sphere distributes the samples evenly
    const double area = 4 * kPi * tool.radius() * tool.radius() / count;
    for (int i = 0; i < count; ++i) {
      const double z = 1 - (2.0 * i + 1) / count, rho = std::sqrt(1 - z * z);
      const dvec3 n(rho * std::cos(golden * i), rho * std::sin(golden * i), z);
      samples.push_back({n * tool.radius(), n, area});
    }
    return samples;
  }
  // Places samples at the quantiles (i + 1/2)/count of a density along the meridian, each turned by the golden angle.
  // The density, area / (height above the end)², puts equally many samples into each doubling of the height.
  const Meridian m = meridian(tool);
  struct Step {
    dvec2 q;
    double area, near_end;
  };
  std::vector<Step> steps;
  double total = 0, total_near_end = 0;
  const double end = -tool.half(), blunt = kBluntEnd * tool.diameter;
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
      const double height = q.y - end, weight = area / (height * height + blunt * blunt);
      total += area;
      total_near_end += weight;
      steps.push_back({q, area, weight});
    }
  }
  double sum = 0;
  std::size_t step = 0;
  const auto fraction = [&](const Step& s) {
    return (1 - near_end) * s.area / total + near_end * s.near_end / total_near_end;
  };
  for (int i = 0; i < count; ++i) {
    const double wanted = (i + 0.5) / count;
    while (step + 1 < steps.size() && sum + fraction(steps[step]) < wanted) sum += fraction(steps[step++]);
    const dvec2 q = steps[step].q;
    const dvec3 p(q.x * std::cos(golden * i), q.x * std::sin(golden * i), q.y);
    const double e = 1e-4 * tool.diameter;
    const dvec3 n = glm::normalize(dvec3(tool.distance(p + dvec3(e, 0, 0)) - tool.distance(p - dvec3(e, 0, 0)),
                                         tool.distance(p + dvec3(0, e, 0)) - tool.distance(p - dvec3(0, e, 0)),
                                         tool.distance(p + dvec3(0, 0, e)) - tool.distance(p - dvec3(0, 0, e))));
    samples.push_back({p, n, steps[step].area / (fraction(steps[step]) * count)});
  }
  return samples;
}

namespace {

void describe_shank(Keys& keys, Tool& tool) {
  keys(must("length_mm"), tool.shank_length, {0.1, 40, kMillimetre}, "length from the head to the handpiece");
  keys("diameter_mm", tool.shank_diameter, {0.05, 10, kMillimetre}, "diameter above the neck");
  tool.neck_diameter = keys.json() ? tool.shank_diameter : kNoDefault;
  keys("neck_mm", tool.neck_diameter, {0.05, 10, kMillimetre}, "diameter at the head; default: `diameter_mm`");
  keys("taper_mm", tool.neck_length, {0, 40, kMillimetre}, "length from the width `neck_mm` to `diameter_mm`");
  const Json* json = keys.json();
  if (!json) return;
  if (tool.neck_diameter > tool.shank_diameter) (*json)["neck_mm"].fail("no wider than the shank");
  if (tool.neck_diameter > tool.diameter * (1 + 1e-9)) {
    json->fail(fmt::format("a neck of {:g} mm", tool.neck_diameter / kMillimetre), "neck_mm no wider than the head");
  }
  // A sudden step from neck to shank would be concave, so a very short cone replaces it.
  if (tool.neck_diameter < tool.shank_diameter) tool.neck_length = std::max(tool.neck_length, 0.01 * kMillimetre);
}

void describe_safe_end(Keys& keys, Tool& tool) {
  keys(must("length_mm"), tool.safe_length, {0.02, 10, kMillimetre}, "length beyond the free end of the head");
  keys(must("diameter_mm"), tool.safe_diameter, {0.02, 10, kMillimetre}, "diameter, at most that of the head");
  if (keys.json() && tool.safe_diameter > tool.diameter * (1 + 1e-9))
    (*keys.json())["diameter_mm"].fail("no wider than the head");
}

void describe_fill(Keys& keys, Tool& tool) {
  if (const auto name = keys(must("tissue"), kName, "tissue of the filling"))
    tool.fill = read_tissue_name(*name, "the name of a tissue, e.g. composite");
  keys(must("rate_mm3_per_s"), tool.fill_rate, {1e-3, 1000, kCubicMillimetre}, "volume that grows per second");
  tool.fill_reach = keys.json() ? tool.radius() : kNoDefault;
  keys("reach_mm", tool.fill_reach, {0.05, 5, kMillimetre}, "distance from the free end; default: the head's radius");
  if (const auto within = keys("within", kSolid, "the filling grows only in this [solid](#solids) without a mesh")) {
    if (!mesh_files(*within).empty()) within->fail("a solid without a mesh: it is asked in every tick");
    tool.fill_within = read_solid(*within);
  }
}

}  // namespace

void describe_tool(Keys& keys, Tool& tool) {
  const Json* json = keys.json();
  keys.define("solid", list_solid);
  keys("name", tool.name, "name of the tool; default: the shape. A tool from a file gets the name of the file");
  keys("iso_6360", tool.iso_code, "ISO 6360 code of the tool");
  keys(must("shape"), tool.shape, kShapeNames, "shape of the head");
  if (json && !json->has("name")) tool.name = name_of(tool.shape);
  keys(must("diameter_mm"), tool.diameter, {0.05, 60, kMillimetre}, "largest diameter of the head");
  if (tool.shape == HeadShape::kSphere) tool.length = tool.diameter;
  const auto length =
      keys("length_mm", kLength,
           "length of the head along its axis; required except for `sphere`, where it is the diameter. For "
           "`round_end_cylinder` and `pear`, at least the diameter; for `flame`, at least 1.5 times the diameter");
  if (json && tool.shape != HeadShape::kSphere) {
    tool.length = (*json)["length_mm"].number(0.05, 60) * kMillimetre;
    if (const double min = kind_of(tool.shape)->min_length; tool.length < min * tool.diameter) {
      length->fail(min == 1 ? "at least the diameter" : fmt::format("at least {:g} times the diameter", min));
    }
  } else if (length && std::abs(length->number() * kMillimetre - tool.diameter) > 1e-9) {
    length->fail("the diameter, or no length, for a sphere");
  }
  keys("cuts", tool.cuts, "false for probes and gauges, which never cut");
  keys("side_efficiency", tool.side_efficiency, {0, 1}, "fraction of the pressing force that cuts at the side");
  keys("end_efficiency", tool.end_efficiency, {0, 1}, "fraction of the pressing force that cuts at the end");
  keys("cutting_coefficient", tool.cutting_coefficient, {0, 10}, "ratio of tangential to pressing force of the edges");
  keys("blades", tool.blades, {1, 64}, "number of blades; the bur then cuts by the law `blade` of each tissue");
  keys("grit_um", tool.grit, {5, 500, kMicrometre},
       "mean size of a diamond's grains; the bur then cuts by the law `grit` of each tissue. Without `grit_um` and "
       "`blades`, a bur cuts with the `specific_energy_J_per_mm3` of each tissue");
  keys("scrapes", tool.scrapes, {0, 10}, "above 0: factor C of a hand instrument, which cuts without rotation");
  keys("sink_yield_N", tool.sink_yield, {0, 20}, "force at which a probe's tip sinks into caries; 0: never");
  if (json && tool.blades > 0 && tool.grit > 0) (*json)["grit_um"].fail("both blades and grit_um", "one of them");
  if (json && tool.scrapes > 0 && !tool.cuts) (*json)["scrapes"].fail("0 for a tool that does not cut");
  keys("shank", tool, describe_shank, "[Shank](#shank-and-safe-end)");
  keys("safe_end", tool, describe_safe_end, "[safe end](#shank-and-safe-end)");
  keys("fill", tool, describe_fill, "[Filling](#filling)");
  if (json && tool.fill != Tissue::kAir) {
    if (json->boolean_or("cuts", false)) (*json)["cuts"].fail("false: what fills does not cut");
    tool.cuts = false;
  }
  const auto any = [&](Keys& of) {
    ImplantTool instrument;
    describe_implant_tool(of, instrument, tool.diameter, 2 * tool.half());
  };
  if (const auto implant = keys("implant", kObject, any, "[Instruments for implants](#instruments-for-implants)")) {
    tool.implant = std::make_shared<const ImplantTool>(read_implant_tool(*implant, tool.diameter, 2 * tool.half()));
    if (tool.fill != Tissue::kAir) implant->fail("no \"fill\" beside it");
  }
  keys("handpiece", tool.handpiece, "the instrument that holds the tool in pictures ([Handpieces](#handpieces))");
  keys.ignore("source");
}

Tool read_tool(const Json& json) {
  return read_keys(json, describe_tool);
}

}  // namespace typodont::haptics
