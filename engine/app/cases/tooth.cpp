#include "engine/app/cases/tooth.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "engine/app/assets.h"
#include "engine/app/cases/pocket_gum.h"
#include "engine/app/cases/scanned_tooth.h"
#include "engine/app/tissue/blend.h"
#include "engine/base/error.h"
#include "engine/base/in_parallel.h"
#include "engine/base/nearest.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/session/dense_field.h"

namespace typodont {

namespace {

constexpr double kBand = 1.5e-3;  // m, distances are stored up to this far from the surface
// limit of random deviations, in standard deviations
constexpr double kMaxDeviation = 2;
// standard deviation of each measure among teeth of equal size, as a fraction of the measure; an estimate
constexpr double kShape = 0.025;
constexpr double kCusp = 0.025;        // standard deviation of a cusp's height and position, as a fraction; an estimate
constexpr double kRootsLeave = 5e-3;   // m, height of the part in which the roots leave the outline of the trunk
constexpr double kTrunkEnd = 1.2e-3;   // m, radius of the rounding at the lower end of the trunk
constexpr double kRootJoin = 1.6e-3;   // m, radius of the rounding where roots join
constexpr double kApex = 0.6e-3;       // m, radius of the tip of each root of a tooth with several roots
constexpr double kApexCurve = 1.4e-3;  // m, radius of the tip of a single root
constexpr double kRootStart = 0.35;  // depth of the upper end of a root's axis, as a fraction of the furcation's depth
// Radius of a root at half its length: 0: as at its upper end, 1: as at its tip. Roots are convex cones.
constexpr double kTaper = 0.3;
constexpr double kBend = 0.14;       // rad, bend of roots to distal at half their length; an estimate
constexpr double kApexShift = 0.06;  // shift of a single root's tip to distal, as a fraction of its length; an estimate
constexpr double kRidgeJoin = 0.9e-3;  // m, ToothHill::join of marginal and other ridges

/// Ratio of the pulp chamber's area at this age to the area at 20 years (CBCT study of 2017 with 316 molars; applied to
/// all teeth).
double pulp_area(const std::string& type, double age) {
  const auto area = [&](double years) { return type[0] == 'U' ? 11.582 - 0.142 * years : 14.249 - 0.163 * years; };
  return area(age) / area(20);
}

Json teeth_table() {
  return Json::load(assets_folder() / "cases" / "teeth.json")["teeth"];
}

/// Resizes a tooth form of the assets to the measures of `tooth`. `neck`: size at the neck, m.
ToothForm resized(ToothForm form, const CaseTooth& tooth, const glm::dvec2& neck) {
  const glm::dvec2 by = glm::dvec2(tooth.md, tooth.bl) / form.widest;
  const double up = tooth.crown / form.height;
  form.widest = {tooth.md, tooth.bl};
  form.neck = neck;
  form.table *= by;
  form.height = tooth.crown;
  form.proximal *= up;
  form.buccal *= up;
  form.lingual *= up;
  form.root = tooth.root;
  for (ToothHill& hill : form.hills) {
    hill.at *= by;
    hill.height *= up;
    hill.slope *= up * 2 / (by.x + by.y);
  }
  return form;
}

/// Outline and edges of the crown from the row of its type. Without sides, the crown is symmetric.
void add_sides(ToothForm& form, const Json& row, double size) {
  form.sides.skew = row["skew"].number(-0.3, 0.3);
  const std::vector<double> narrow = row["narrow"].numbers(2), corners = row["corners_mm"].numbers(2);
  form.sides.distal_narrow = narrow[0];
  form.sides.lingual_narrow = narrow[1];
  form.sides.distal_lower = row["distal_lower_mm"].number(0, 2) * kMillimetre * size;
  form.sides.corners = glm::dvec2(corners[0], corners[1]) * kMillimetre * size;
  // The skewed superellipse is wider along x, by the norm of its dual.
  const double dual = form.square / (form.square - 1),
               across = std::abs(form.sides.skew) * form.widest.y / form.widest.x;
  const double wider = std::pow(1 + std::pow(across, dual), 1 / dual);
  form.widest.x /= wider;
  form.table.x /= wider;
}

/// Shift of the middle of a single root to distal (negative) at height z, m.
double root_shift(const CaseTooth& tooth, double z) {
  const double t = std::min(z, 0.0) / tooth.root;
  return tooth.roots.empty() ? -kApexShift * tooth.root * t * t : 0;
}

/// Adds the pulp: chamber, horns and canals. `size`: size of the chamber at the neck, m. `shrink`: factor for the age.
void add_pulp(CaseTooth& tooth, const glm::dvec2& size, double shrink) {
  const glm::dvec2 half = 0.5 * size * shrink;
  // Molars: height of the chamber 1.6 to 1.9 mm, its roof at the neck (Deutsch & Musikant 2004).
  const bool molar = tooth.type[1] >= '6';
  tooth.chamber_roof = molar ? 0.4e-3 : 0.4 * tooth.crown * shrink;
  tooth.chamber_floor = molar ? tooth.chamber_roof - 1.9e-3 * shrink : -0.3 * tooth.root;
  const double thin = std::min(half.x, half.y);
  const auto tube = [&](const dvec3& a, const dvec3& b, double ra, double rb, double stretch) {
    tooth.pulp.push_back({a, b, ra, rb, stretch});
  };
  constexpr double kCanal = 0.35e-3, kForamen = 0.15e-3;  // m, radii of a canal and of its foramen
  if (!molar) {
    const double above = tooth.chamber_roof;
    tube({0, 0, above}, {0, 0, tooth.chamber_floor}, 0.55 * half.x, half.x, half.y / half.x);
    if (tooth.roots.empty()) {
      const auto middle = [&](double z) { return dvec3(root_shift(tooth, z), 0, z); };
      tube(middle(tooth.chamber_floor), middle(-tooth.root + 1e-3), half.x, kForamen, 1.6);
    }
  } else {
    const double middle = 0.5 * (tooth.chamber_roof + tooth.chamber_floor);
    const double height = 0.5 * (tooth.chamber_roof - tooth.chamber_floor);
    // The chamber consists of overlapping tubes along its longer side.
    for (const double side : {-1.0, -0.33, 0.33, 1.0}) {
      const double x = side * std::max(half.x - height, 0.0);
      tube({x, -std::max(half.y - height, 0.0), middle}, {x, std::max(half.y - height, 0.0), middle}, height, height,
           1);
    }
    for (const ToothHill& hill : tooth.form.hills) {
      if (hill.height < 0.83 * tooth.crown || !hill.is_cusp()) continue;
      const glm::dvec2 at = glm::clamp(hill.at, -half + 0.4e-3, half - 0.4e-3);
      tube({at.x, at.y, middle}, {at.x * 1.1, at.y * 1.1, tooth.chamber_roof + 1.1e-3 * shrink}, 0.6 * height + 0.1e-3,
           0.2e-3, 1);
    }
  }
  for (std::size_t k = 0; k < tooth.roots.size(); ++k) {
    const TaperedTube& root = tooth.roots[k];
    const double stretch = std::min(root.stretch_y, 2.0);
    const bool upper = k % 2 == 0;
    const glm::dvec2 at = glm::clamp(glm::dvec2(root.a), -half + 0.5 * thin, half - 0.5 * thin);
    if (upper) tube({at.x, at.y, tooth.chamber_floor + 0.3e-3}, root.a, 1.3 * kCanal, kCanal, stretch);
    const dvec3 end = upper ? root.b : root.b + 0.02 * (root.a - root.b);
    constexpr double kMiddle = 0.5 * (kCanal + kForamen);
    tube(root.a, end, upper ? kCanal : kMiddle, upper ? kMiddle : kForamen, stretch);
  }
}

}  // namespace

double uniform(SplitMix64& random) {
  return static_cast<double>(random.next() >> 11) * 0x1p-53;
}

double normal(SplitMix64& random) {
  double sum = -6;  // of twelve uniform numbers
  for (int i = 0; i < 12; ++i) sum += uniform(random);
  return std::clamp(sum, -kMaxDeviation, kMaxDeviation);
}

double TaperedTube::distance(const dvec3& p) const {
  const dvec3 by(1, 1 / stretch_y, 1);
  const dvec3 q = p * by, from = a * by, to = b * by;
  return distance_to_segment(from, to, q) - glm::mix(radius_a, radius_b, nearest_fraction(from, to, q));
}

double CaseTooth::distance(const dvec3& p) const {
  if (scan) return scan->distance(p);
  const dvec3 q(p.x - root_shift(*this, p.z), p.y, p.z);
  const double trunk = hollowed(form, q);
  if (roots.empty()) {
    // The root ends as a paraboloid.
    const double up = std::max(q.z + root, 0.0);
    const double out = std::hypot(q.x, q.y * form.neck.x / form.neck.y) - std::sqrt(2 * kApexCurve * up);
    return q.z > 0 ? trunk : smooth_max(trunk, 0.6 * out, 1e-3);
  }
  double d = smooth_max(trunk, -furcation - p.z, kTrunkEnd);
  for (std::size_t k = 0; k + 1 < roots.size(); k += 2)
    d = smooth_min(d, std::min(roots[k].distance(p), roots[k + 1].distance(p)), kRootJoin);
  // The roots leave the outline of the trunk gradually; their rounded union does not bulge out of it.
  return glm::mix(d, std::max(d, trunk), smooth_step(-furcation - kRootsLeave, -furcation, p.z));
}

double CaseTooth::hollowed(const ToothForm& outer, const dvec3& p) const {
  const double d = outer.distance(p);
  if (fossa == 0 || p.y > 0 || p.z < 0) return d;
  // Lingual fossa: ellipsoid between marginal ridges, edge and cingulum.
  const dvec3 half(0.34 * md, 2 * fossa, 0.3 * crown);
  const double z = 0.58 * crown, t = (z - outer.lingual) / (crown - outer.lingual);
  const double side = 0.5 * (bl - (bl - outer.table.y) * t * t) + outer.lean * z;
  const dvec3 q = (p - dvec3(0, -side - fossa, z)) / half;
  return smooth_max(d, (1 - glm::length(q)) * half.y, 1.3e-3);
}

double CaseTooth::pulp_distance(const dvec3& p) const {
  if (scan) return scan->pulp_distance(p);
  double d = 1;
  for (const TaperedTube& tube : pulp) d = std::min(d, tube.distance(p));
  return d;
}

Tissue CaseTooth::tissue(const dvec3& p) const {
  if (scan) return scan->tissue(p);
  if (pulp_distance(p) < 0) return Tissue::kPulp;
  // The edge of the enamel rises towards the neighbouring teeth.
  const double c = p.x / (std::hypot(p.x, p.y) + 1e-6);
  const double edge = (c > 0 ? cej_mesial : cej_distal) * c * c;
  const double up = (p.z - edge) / (0.6 * crown);
  // Thickness of the enamel by thirds of the crown (OpenMandible), relative to the occlusal (upper) third: 0.75 in the
  // middle third, 0.35 at the neck.
  const double thick = enamel * (up <= 0 ? 0 : std::min(1.0, 0.25 + 0.75 * up) * std::min(1.0, up / 0.06));
  return thick > 0 && -hollowed(blunt, p) < thick ? Tissue::kEnamel : Tissue::kDentin;
}

double CaseTooth::surface(double x, double y) const {
  double low = 0, high = crown + 1e-3;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    const dvec3 p(x, y, middle);
    ((scan ? scan->distance(p) : hollowed(form, p)) < 0 ? low : high) = middle;
  }
  return low;
}

double CaseTooth::fissure(double x) const {
  double best = 0, lowest = 1;
  for (double y = -0.22 * bl; y <= 0.22 * bl; y += 0.05e-3)
    if (const double z = surface(x, y); z < lowest) lowest = z, best = y;
  return best;
}

std::vector<std::string> tooth_types() {
  return teeth_table().keys();
}

std::string tooth_name(const std::string& type) {
  return teeth_table()[type]["name"].string();
}

CaseTooth make_tooth(const std::string& type, double age, SplitMix64& random, double curvature) {
  const Json table = teeth_table();
  const auto row = table.find(type);
  if (!row) throw Error("tooth", "", type, fmt::format("one of {}", fmt::join(tooth_types(), ", ")));
  CaseTooth tooth;
  tooth.type = type;
  tooth.name = (*row)["name"].string();
  tooth.age = age;
  const double size = 1 + (*row)["size_sd"].number(0, 0.2) * normal(random);
  const auto measure = [&](double mean_mm) { return mean_mm * kMillimetre * size * (1 + kShape * normal(random)); };
  tooth.md = measure((*row)["md_mm"].number(3, 15));
  tooth.bl = measure((*row)["bl_mm"].number(3, 15));
  tooth.crown = measure((*row)["crown_mm"].number(4, 14));
  tooth.root = measure((*row)["root_mm"].number(6, 22));
  const std::vector<double> neck_mm = (*row)["neck_mm"].numbers(2);
  const glm::dvec2 neck(measure(neck_mm[0]), measure(neck_mm[1]));
  const std::string form = (*row)["form"].string();
  tooth.form = read_tooth_form(Json::load(tooth_forms() / (form + ".json")));
  tooth.form = resized(tooth.form, tooth, neck);
  add_sides(tooth.form, *row, size);
  const auto cusps = static_cast<std::size_t>((*row)["cusps"].integer(1, 5));
  for (std::size_t k = cusps; k < tooth.form.hills.size(); ++k) tooth.form.hills[k].join = kRidgeJoin;
  for (ToothHill& hill : tooth.form.hills) {
    hill.at += kCusp * glm::dvec2(normal(random), normal(random)) * glm::dvec2(tooth.md, tooth.bl) * 0.5;
    hill.height = std::min(hill.height * (1 + 0.5 * kCusp * normal(random)), tooth.crown);
  }
  tooth.blunt = tooth.form;
  tooth.blunt.groove_depth = 0;
  tooth.fossa = (*row)["fossa_mm"].number(0, 2) * kMillimetre * size;
  const std::vector<double> cej = (*row)["cej_mm"].numbers(2);
  tooth.cej_mesial = cej[0] * kMillimetre * size;
  tooth.cej_distal = cej[1] * kMillimetre * size;
  tooth.enamel = (*row)["enamel_mm"].number(0.3, 3) * kMillimetre * size;
  tooth.furcation = (*row)["furcation_mm"].number(0, 12) * kMillimetre * size;
  for (const Json& item : (*row)["roots"].items()) {
    const std::vector<double> r = item.numbers(7);
    const glm::dvec2 half = 0.5 * neck;
    const double sway = 0.06 * normal(random);
    TaperedTube upper, lower;
    upper.a = {r[0] * half.x, r[1] * half.y, -kRootStart * tooth.furcation};
    const dvec3 tip((r[2] + sway) * half.x, r[3] * half.y, -r[6] * tooth.root + kApex);
    upper.radius_a = r[4] * half.x;
    upper.stretch_y = lower.stretch_y = r[5] * half.y / (r[4] * half.x);
    upper.b = lower.a = glm::mix(upper.a, tip, 0.5);
    upper.radius_b = lower.radius_a = glm::mix(upper.radius_a, kApex, kTaper);
    lower.b = lower.a + glm::angleAxis(curvature > 0 ? curvature : kBend, dvec3(0, 1, 0)) * (tip - lower.a);
    lower.radius_b = kApex;
    tooth.roots.push_back(upper);
    tooth.roots.push_back(lower);
  }
  const std::vector<double> pulp = (*row)["pulp_mm"].numbers(2);
  add_pulp(tooth, glm::dvec2(pulp[0], pulp[1]) * kMillimetre * size, std::sqrt(pulp_area(type, age)));
  return tooth;
}

haptics::DenseTissue sample_tooth(const CaseTooth& tooth, double voxel, const PocketGum* gum) {
  haptics::DenseTissue out;
  out.band = kBand;
  out.frame.voxel = voxel;
  dvec3 low = tooth.form.low(), high = tooth.form.high();
  for (const TaperedTube& root : tooth.roots) {
    const dvec3 wide = root.radius_a * dvec3(1, root.stretch_y, 1);
    low = glm::min(low, glm::min(root.a, root.b) - wide);
    high = glm::max(high, glm::max(root.a, root.b) + wide);
  }
  if (gum) {
    low = glm::min(low, gum->low());
    high = glm::max(high, gum->high());
  }
  const auto distance = [&](const dvec3& p) {
    return gum ? std::min(tooth.distance(p), gum->distance(p)) : tooth.distance(p);
  };
  out.frame.origin = voxel * glm::floor((low - kBand) / voxel);
  out.size = glm::ivec3(glm::ceil((high + kBand - out.frame.origin) / voxel)) + 1;
  session::DenseField field{out.size, std::vector<float>(voxel_count(out.size))};
  const auto columns = static_cast<std::size_t>(out.size.x) * static_cast<std::size_t>(out.size.y);
  const auto at = [&](std::size_t column, int z) {
    const auto rows = static_cast<std::size_t>(out.size.y);
    return out.frame.to_world(dvec3(column / rows, column % rows, z));
  };
  in_parallel(columns, [&](std::size_t column) {
    for (int z = 0; z < out.size.z; ++z) {
      const dvec3 p = at(column, z);
      double d = distance(p);
      if (std::abs(d) < 4 * voxel) d = first_order_distance(distance, p, d, 0.25 * voxel, 0.5);
      field.distance[column * static_cast<std::size_t>(out.size.z) + static_cast<std::size_t>(z)] =
          static_cast<float>(d / voxel);
    }
  });
  field = session::redistanced(field);
  out.distance.resize(field.distance.size());
  out.tissue.assign(field.distance.size(), Tissue::kAir);
  in_parallel(columns, [&](std::size_t column) {
    for (int z = 0; z < out.size.z; ++z) {
      const std::size_t i = column * static_cast<std::size_t>(out.size.z) + static_cast<std::size_t>(z);
      const double d = static_cast<double>(field.distance[i]);
      out.distance[i] = static_cast<float>(std::clamp(d * voxel, -kBand, kBand));
      if (d >= 2) continue;
      const dvec3 p = at(column, z);
      const double to_tooth = gum ? tooth.distance(p) : 0;
      out.tissue[i] = to_tooth > 0 && gum->distance(p) < to_tooth ? Tissue::kGingiva : tooth.tissue(p);
    }
  });
  return out;
}

}  // namespace typodont
