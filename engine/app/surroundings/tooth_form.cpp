#include "engine/app/surroundings/tooth_form.h"

#include <algorithm>
#include <cmath>

#include "engine/app/surroundings/blend.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

constexpr double kTip = 0.45e-3;  // m, radius of a hill's tip
// Factor that keeps the distance to the side below the true one.
constexpr double kSideSlope = 0.9;
// Factor that keeps the distance to the top below the true one.
constexpr double kTopSlope = 0.78;
// Radius of a groove's floor, m. Sharper grooves would show notches of voxels.
constexpr double kGrooveFloor = 0.2e-3;
constexpr double kRidges = 0.07e-3;    // m, amplitude of the fine ridges on the cusps
constexpr double kEnamelTop = 1.9e-3;  // m, thickness of the enamel at the chewing surface
constexpr double kPulpDepth = 2.7e-3;  // m, depth of the pulp below the surface
constexpr double kMargin = 0.6e-3;     // m, margin of the box around the tooth
constexpr double kThinnest = 0.1e-3;   // m, smallest width above a thin edge
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

/// Height of the fine ridges on a hill, m. `from_tip`: position relative to the tip, m; `over`: height above the second
/// highest hill, m. Zero at tips and in grooves.
double ridges(const glm::dvec2& from_tip, double over) {
  const double r2 = glm::dot(from_tip, from_tip) + 1e-9, c = from_tip.x * from_tip.x / r2;
  // cos(4 φ), with c = cos² φ.
  const double wave = 8 * c * c - 8 * c + 1;
  return kRidges * wave * std::min(r2 / 1.5e-6, 1.0) * std::clamp(over / 0.3e-3, 0.0, 1.0);
}

}  // namespace

double ToothForm::distance(const dvec3& p) const {
  const double z = p.z;
  const double x = p.x, y = p.y + lean * std::max(z, 0.0);
  const double a = half_width(z, neck.x, widest.x, table.x, proximal, height, root);
  const double b = half_width(z, neck.y, widest.y, table.y, y > 0 ? buccal : lingual, height, root);
  // The superellipse is slow to compute, so it is used only near the ellipse with the same axes.
  const double r = std::sqrt(x * x + y * y), ellipse = std::sqrt(x * x / (a * a) + y * y / (b * b));
  const double at_most = ellipse > 1e-3 ? kSideSlope * (r - r / ellipse) : -kSideSlope * std::min(a, b);
  const auto outline = [&] {
    // Far away, a lower bound of the distance is enough.
    if (ellipse < 0.55 || ellipse > 2) return at_most;
    const double n = std::pow(std::pow(std::abs(x) / a, square) + std::pow(std::abs(y) / b, square), 1 / square);
    return kSideSlope * (r - r / n);
  };
  if (z < 0.3 * height) return smooth_max(outline(), -root - z, 1e-3);

  // Highest hill at (x, y); grooves are where hills meet.
  double first = -1, second = -1;
  glm::dvec2 from_tip(0);
  for (const ToothHill& hill : hills) {
    const glm::dvec2 d = (glm::dvec2(x, y) - hill.at) / hill.long_by;
    const double h = hill.height - hill.slope * (std::sqrt(glm::dot(d, d) + kTip * kTip) - kTip);
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
  const double top = kTopSlope * (z - height_of_hills - ridges(from_tip, over));
  return at_most + rounding < top ? top : smooth_max(outline(), top, rounding);
}

Tissue ToothForm::tissue(const dvec3& p) const {
  const double inside = -distance(p);
  if (inside > kPulpDepth && p.z < 0.5 * height) return Tissue::kPulp;
  const double enamel = kEnamelTop * std::clamp(p.z / (0.6 * height), 0.0, 1.0);
  return p.z > 0 && inside < enamel + 1e-5 ? Tissue::kEnamel : Tissue::kDentin;
}

dvec3 ToothForm::low() const {
  const glm::dvec2 half = 0.5 * glm::max(widest, neck) + kMargin;
  return {-half.x, -half.y - std::max(lean, 0.0) * height, -root - kMargin};
}
dvec3 ToothForm::high() const {
  const glm::dvec2 half = 0.5 * glm::max(widest, neck) + kMargin;
  return {half.x, half.y + std::max(-lean, 0.0) * height, height + kMargin};
}

ToothForm read_tooth_form(const Json& json) {
  json.allow_only({"widest_mm", "neck_mm", "table_mm", "height_mm", "contour_mm", "square", "rounding_mm", "lean_deg",
                   "root_mm", "groove_mm", "hills", "source"});
  const auto pair = [](const Json& value, double least, double most) {
    const std::vector<double> v = value.numbers(2);
    for (const double x : v)
      if (x < least || x > most) value.fail("two lengths in millimetres in the valid range");
    return glm::dvec2(v[0], v[1]) * kMillimetre;
  };
  ToothForm form;
  form.widest = pair(json["widest_mm"], 2, 16);
  form.neck = pair(json["neck_mm"], 2, 16);
  form.table = pair(json["table_mm"], 0.3, 16);
  form.height = json["height_mm"].number(3, 16) * kMillimetre;
  const std::vector<double> contour = json["contour_mm"].numbers(3);
  for (const double c : contour)
    if (c < 0.2 || c > form.height / kMillimetre - 0.2) json["contour_mm"].fail("three heights within the crown");
  form.proximal = contour[0] * kMillimetre;
  form.buccal = contour[1] * kMillimetre;
  form.lingual = contour[2] * kMillimetre;
  form.square = json.number_or("square", form.square, 1.5, 6);
  form.rounding = json["rounding_mm"].number(0.1, 4) * kMillimetre;
  form.lean = std::tan(json.number_or("lean_deg", 0, -30, 30) * kDegree);
  form.root = json["root_mm"].number(4, 25) * kMillimetre;
  const glm::dvec2 groove = pair(json["groove_mm"], 0, 2);
  form.groove_depth = groove.x;
  form.groove_width = std::max(groove.y, 1e-5);
  for (const Json& item : json["hills"].items()) {
    item.allow_only({"at_mm", "height_mm", "slope", "long"});
    ToothHill hill;
    hill.at = pair(item["at_mm"], -8, 8);
    hill.height = item["height_mm"].number(1, 16) * kMillimetre;
    hill.slope = item["slope"].number(0.05, 2);
    if (const auto v = item.find("long")) hill.long_by = pair(*v, 0.1, 20) / kMillimetre;
    form.hills.push_back(hill);
  }
  if (form.hills.empty() || form.hills.size() > 12) json["hills"].fail("1 to 12 hills");
  return form;
}

}  // namespace typodont
