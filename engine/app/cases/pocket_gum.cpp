#include "engine/app/cases/pocket_gum.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/app/tissue/blend.h"

namespace typodont {

namespace {

constexpr double kPocketGap = 0.7e-3;  // m, width of a pocket between root and gum; the probe's ball has 0.5 mm
constexpr double kSulcusSide = 0.42;   // half the length of the sulcus on each side, as a fraction of the neck's width
constexpr double kThinEdge = 0.45e-3;  // m, thickness of the gum near its margin
constexpr double kThick = 1.6e-3;      // m, thickness of the gum below
constexpr double kThickens = 2.5e-3;   // m, depth over which the gum becomes thick
constexpr double kAboveMargin = 1e-3;  // m, largest height of a papilla above the margin
constexpr double kBelowRoot = 1e-3;    // m, depth of the block's base below the root
constexpr double kSearchStep = 0.01e-3;  // m, step of the search for the tooth's surface

/// Distance to the tooth's surface, m; corrected near it.
double distance_to(const CaseTooth& tooth, const dvec3& p) {
  const double d = tooth.distance(p);
  if (d <= 0 || d > 3 * kPocketGap) return d;
  return first_order_distance(std::bind_front(&CaseTooth::distance, &tooth), p, d, 0.05e-3, 0.3);
}

}  // namespace

double PocketGum::margin(const dvec3& p) const {
  const double c = p.x / (std::hypot(p.x, p.y) + 1e-6);
  return (c > 0 ? tooth->cej_mesial : tooth->cej_distal) * c * c + kFreeGum;
}

void PocketGum::add_pocket(double x, double side, double depth, double half_width) {
  dvec3 on(x, side * tooth->bl, kFreeGum);
  while (side * on.y > 0 && distance_to(*tooth, on) > 0) on.y -= side * kSearchStep;
  on.z = margin(on);
  Pocket pocket;
  pocket.out = central_difference(std::bind_front(&CaseTooth::distance, tooth), on, 0.1e-3);
  pocket.out = glm::normalize(dvec3(pocket.out.x, pocket.out.y, 0));
  pocket.half_width = half_width;
  // Middle of the gap at the height z, in the vertical plane through the site.
  const auto middle = [&](double z) {
    dvec3 p = on + 2e-3 * pocket.out;
    p.z = z;
    while (glm::dot(p, pocket.out) > 0 && distance_to(*tooth, p) > 0.5 * kPocketGap) p -= kSearchStep * pocket.out;
    return p;
  };
  pocket.margin = middle(on.z);
  pocket.floor = middle(on.z - depth);
  pockets.push_back(pocket);
}

double PocketGum::distance(const dvec3& p) const {
  const double deep = margin(p) - p.z;
  // The gum has its thickness beside the crown, and beside the vertical cylinder through the neck.
  const double r = std::hypot(p.x, p.y), n = tooth->form.square;
  const double f = std::pow(
      std::pow(2 * std::abs(p.x) / tooth->form.neck.x, n) + std::pow(2 * std::abs(p.y) / tooth->form.neck.y, n), 1 / n);
  const double from_neck = f > 1e-3 ? r - r / f : -0.5 * std::min(tooth->form.neck.x, tooth->form.neck.y);
  const double to_tooth = distance_to(*tooth, p);
  const double thick = gum_thickness(deep, kThinEdge, kThick, kThickens);
  const double from_side = p.z > 0 ? std::min(from_neck, to_tooth) : from_neck;
  double body = std::max(from_side - kPocketGap - thick, -deep - kAboveMargin);
  body = smooth_max(body, std::abs(p.x) - 0.5 * tooth->md, 0.6e-3);
  body = smooth_max(body, -tooth->root - kBelowRoot - p.z, 1e-3);
  const double gap = to_tooth - kPocketGap;
  double air = std::max({gap, deep - sulcus, std::abs(p.x) - kSulcusSide * tooth->form.neck.x});
  for (const Pocket& pocket : pockets) {
    const dvec3 from = p - pocket.margin;
    const double aside = std::abs(glm::dot(from, dvec3(-pocket.out.y, pocket.out.x, 0)));
    if (glm::dot(p, pocket.out) < 0) continue;
    air = std::min(air, std::max({gap, aside - pocket.half_width, pocket.floor.z - p.z}));
  }
  return std::max(body, -air);
}

dvec3 PocketGum::low() const {
  return {-0.5 * tooth->md, -0.5 * tooth->form.neck.y - kPocketGap - kThick, -tooth->root - kBelowRoot};
}
dvec3 PocketGum::high() const {
  return {0.5 * tooth->md, 0.5 * tooth->form.neck.y + kPocketGap + kThick, tooth->crown};
}

}  // namespace typodont
