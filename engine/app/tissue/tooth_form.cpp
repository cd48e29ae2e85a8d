#include "engine/app/tissue/tooth_form.h"

#include <algorithm>
#include <cmath>

#include "engine/app/assets.h"
#include "engine/app/tissue/blend.h"
#include "engine/base/keys.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

constexpr double kTip = 0.45e-3;  // m, radius of the tip of a hill (cusp)
// Factor that keeps the computed distance to the tooth's side below the true distance.
constexpr double kSideSlope = 0.9;
// Factor that keeps the computed distance to the tooth's top below the true distance.
constexpr double kTopSlope = 0.78;
// Radius of a groove's floor, m. Sharper grooves would show notches of voxels.
constexpr double kGrooveFloor = 0.2e-3;
constexpr double kRidges = 0.07e-3;    // m, amplitude of the fine ridges on the cusps
constexpr double kEnamelTop = 1.9e-3;  // m, thickness of the enamel at the chewing surface
constexpr double kPulpDepth = 2.7e-3;  // m, depth of the pulp below the surface
constexpr double kMargin = 0.6e-3;     // m, margin of the box around the tooth
constexpr double kThinnest = 0.1e-3;   // m, smallest width of the tooth at any height
constexpr double kRootEnd = 0.35;      // root end's width, as a fraction of the neck's

/// Half the width of the tooth at height z, m.
double half_width(double z, double neck, double widest, double table, double at, double height, double root) {
  if (z < 0) {
    const double t = std::min(-z / root, 1.0);
    return 0.5 * neck * (1 - (1 - kRootEnd) * t * t);
  }
  if (z < at) return 0.5 * (neck + (widest - neck) * std::sin(0.5 * kPi * z / at));
  const double t = std::min((z - at) / (height - at), 1.3);
  return 0.5 * std::max(widest - (widest - table) * t * t, kThinnest);
}

/// Height of the fine ridges on a hill (cusp), m; zero at its tip and in grooves. `from_tip`: position relative to the
/// tip, m. `over`: height above the second highest hill, m.
double ridges(const glm::dvec2& from_tip, double over) {
  const double r2 = glm::dot(from_tip, from_tip) + 1e-9, c = from_tip.x * from_tip.x / r2;
  // cos(4 φ), with c = cos² φ.
  const double wave = 8 * c * c - 8 * c + 1;
  return kRidges * wave * std::min(r2 / 1.5e-6, 1.0) * std::clamp(over / 0.3e-3, 0.0, 1.0);
}

}  // namespace

double ToothForm::distance(const dvec3& p) const {
  const double z = p.z;
  const double y = p.y + lean * std::max(z, 0.0);
  // The neck is symmetric; from there, the sides' differences grow up to the widest point.
  const double grown = std::clamp(z / proximal, 0.0, 1.0);
  const double x = p.x - grown * sides.skew * y;
  const double widest_at = x > 0 ? proximal : proximal - sides.distal_lower;
  const double even_a = half_width(z, neck.x, widest.x, table.x, widest_at, height, root);
  const double even_b = half_width(z, neck.y, widest.y, table.y, y > 0 ? buccal : lingual, height, root);
  const double to_mesial = std::clamp(x / even_a, -1.0, 1.0), to_buccal = std::clamp(y / even_b, -1.0, 1.0);
  const double a = even_a * (1 + grown * sides.lingual_narrow * to_buccal);
  const double b = even_b * (1 + grown * sides.distal_narrow * to_mesial);
  // The superellipse is slow to compute, so it is evaluated only near the ellipse with the same axes.
  const double r = std::sqrt(x * x + y * y), ellipse = std::sqrt(x * x / (a * a) + y * y / (b * b));
  const double at_most = ellipse > 1e-3 ? kSideSlope * (r - r / ellipse) : -kSideSlope * std::min(a, b);
  const auto outline = [&] {
    // Far away, a lower bound of the distance is enough. Outside, the distance changes to it without a step.
    if (ellipse < 0.55 || ellipse > 2) return at_most;
    const double n = std::pow(std::pow(std::abs(x) / a, square) + std::pow(std::abs(y) / b, square), 1 / square);
    return glm::mix(kSideSlope * (r - r / n), at_most, smooth_step(1.75, 2, ellipse));
  };
  if (z < 0.3 * height) return smooth_max(outline(), -root - z, 1e-3);

  // Heights of the highest and second highest hill (cusp) at (x, y). A groove is where two hills meet.
  double first = -1, second = -1;
  glm::dvec2 from_tip(0);
  const auto beside = [&](const ToothHill& hill) { return (glm::dvec2(p.x, y) - hill.at) / hill.long_by; };
  const auto height_at = [&](const ToothHill& hill, const glm::dvec2& d) {
    return hill.height - hill.slope * (std::sqrt(glm::dot(d, d) + kTip * kTip) - kTip);
  };
  for (const ToothHill& hill : hills) {
    if (!hill.is_cusp()) continue;
    const glm::dvec2 d = beside(hill);
    const double h = height_at(hill, d);
    if (h > first) {
      second = first;
      first = h;
      from_tip = d;
    } else {
      second = std::max(second, h);
    }
  }
  const double over = first - second, meet = over / groove_width;
  double height_of_hills = 0.5 * (first + second + std::sqrt(over * over + kGrooveFloor * kGrooveFloor));
  if (meet < 3) height_of_hills -= groove_depth * std::exp(-meet * meet);
  for (const ToothHill& hill : hills)
    if (!hill.is_cusp()) height_of_hills = smooth_max(height_of_hills, height_at(hill, beside(hill)), hill.join);
  const double top = kTopSlope * (z - height_of_hills - ridges(from_tip, over));
  const double round =
      rounding + sides.corners.x * smooth_step(0.3, 1, to_mesial) + sides.corners.y * smooth_step(0.3, 1, -to_mesial);
  return at_most + round < top ? top : smooth_max(outline(), top, round);
}

Tissue ToothForm::tissue(const dvec3& p) const {
  const double inside = -distance(p);
  if (inside > kPulpDepth && p.z < 0.5 * height) return Tissue::kPulp;
  const double enamel = kEnamelTop * std::clamp(p.z / (0.6 * height), 0.0, 1.0);
  return p.z > 0 && inside < enamel + 1e-5 ? Tissue::kEnamel : Tissue::kDentin;
}

glm::dvec2 ToothForm::half_box() const {
  const glm::dvec2 more(std::abs(sides.lingual_narrow), std::abs(sides.distal_narrow));
  const glm::dvec2 half = 0.5 * glm::max(widest, neck) * (1.0 + more) + kMargin;
  return half + glm::dvec2(std::abs(sides.skew) * half.y, 0);
}

dvec3 ToothForm::low() const {
  const glm::dvec2 half = half_box();
  return {-half.x, -half.y - std::max(lean, 0.0) * height, -root - kMargin};
}
dvec3 ToothForm::high() const {
  const glm::dvec2 half = half_box();
  return {half.x, half.y + std::max(-lean, 0.0) * height, height + kMargin};
}

namespace {

glm::dvec2 read_pair(const Json& value, double min, double max) {
  const std::vector<double> v = value.numbers(2);
  for (const double x : v)
    if (x < min || x > max) value.fail("two lengths in millimetres in the valid range");
  return glm::dvec2(v[0], v[1]) * kMillimetre;
}

void describe_hill(Keys& keys, ToothHill& hill) {
  if (const auto at = keys(must("at_mm"), kPair, "x and y of the cusp, −8–8")) hill.at = read_pair(*at, -8, 8);
  keys(must("height_mm"), hill.height, {1, 16, kMillimetre}, "height above the neck");
  keys(must("slope"), hill.slope, {0.05, 2}, "slope of the sides");
  if (const auto v = keys("long", kPair, "stretch along x and y, 0.1–20; default [1, 1]"))
    hill.long_by = read_pair(*v, 0.1, 20) / kMillimetre;
}

}  // namespace

std::filesystem::path tooth_forms() {
  return assets_folder() / "teeth" / "forms";
}

void describe_tooth_form(Keys& keys, ToothForm& form) {
  if (const auto v = keys(must("widest_mm"), kPair, "widths along x and y at the widest part, 2–16"))
    form.widest = read_pair(*v, 2, 16);
  if (const auto v = keys(must("neck_mm"), kPair, "widths at the neck, 2–16")) form.neck = read_pair(*v, 2, 16);
  if (const auto v = keys(must("table_mm"), kPair, "widths at the occlusal end, 0.3–16"))
    form.table = read_pair(*v, 0.3, 16);
  keys(must("height_mm"), form.height, {3, 16, kMillimetre}, "height of the crown");
  if (const auto v =
          keys(must("contour_mm"), kPoint, "height of the widest part at the proximal, buccal and lingual sides")) {
    const std::vector<double> contour = v->numbers(3);
    for (const double c : contour)
      if (c < 0.2 || c > form.height / kMillimetre - 0.2) v->fail("three heights within the crown");
    form.proximal = contour[0] * kMillimetre;
    form.buccal = contour[1] * kMillimetre;
    form.lingual = contour[2] * kMillimetre;
  }
  keys("square", form.square, {1.5, 6}, "exponent of the outline");
  keys(must("rounding_mm"), form.rounding, {0.1, 4, kMillimetre}, "radius of the edges");
  double lean = 0;
  keys("lean_deg", lean, {-30, 30, kDegree}, "inclination");
  form.lean = std::tan(lean);
  keys(must("root_mm"), form.root, {4, 25, kMillimetre}, "length of the root");
  if (const auto v = keys(must("groove_mm"), kPair, "depth and width of the grooves, 0–2")) {
    const glm::dvec2 groove = read_pair(*v, 0, 2);
    form.groove_depth = groove.x;
    form.groove_width = std::max(groove.y, 1e-5);
  }
  keys(must("hills"), form.hills, describe_hill, "1 to 12 cusps, ridges and edges");
  if (keys.json() && (form.hills.empty() || form.hills.size() > 12)) (*keys.json())["hills"].fail("1 to 12 hills");
  keys.ignore("source");
}

ToothForm read_tooth_form(const Json& json) {
  return read_keys(json, describe_tooth_form);
}

}  // namespace typodont
