#include "haptics/contact/proxy/crease.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"
#include "haptics/contact/proxy/parameters.h"

namespace typodont::haptics {

namespace {

using C = CreaseParameters;

/// Any unit vector perpendicular to n.
dvec3 across(const dvec3& n) noexcept {
  return glm::normalize(glm::cross(n, std::abs(n.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
}

/// Signed distance of (u, w) from a circle with curvature k through the origin, where its normal is (0, 1). The
/// gradient of the distance is (k u, 1 + k w) / root.
double from_circle(double u, double w, double k, double& root) noexcept {
  const double twice = k * (u * u + w * w) + 2 * w;
  root = std::sqrt(std::max(1 + k * twice, 1e-12));
  return twice / (1 + root);
}

/// A point on the tissue's surface beside the crease, and the normal there by linear interpolation.
struct Landing {
  dvec3 x{0}, n{0};
};

bool land(const TissuePatch& patch, dvec3 x, Landing& landing) noexcept {
  for (int step = 0; step < C::steps; ++step) {
    if (!patch.holds(x, 0)) return false;
    const FieldSample at = sample_linear_gradient(patch, x);
    const double slope = glm::length(at.gradient);
    if (slope < 0.5) return false;
    const dvec3 n = at.gradient / slope;
    landing = {x - (at.value / slope) * n, n};
    if (std::abs(at.value) < C::landed) return true;
    x = landing.x;
  }
  return false;
}

/// Largest difference between a sheet (smooth surface) and the field two voxels from `at`; `f`: sample at `at`.
double off_samples(const float* f, const std::ptrdiff_t (&step)[3], const glm::ivec3& at, const Sheet& sheet) noexcept {
  double most = 0;
  for (int i = 0; i < 3; ++i) {
    for (const int way : {-2, 2}) {
      dvec3 p(at);
      p[i] += way;
      most = std::max(most, std::abs(sheet.distance(p) - f[way * step[i]]));
    }
  }
  return most;
}

/// Fits a sheet (smooth surface) to the samples around the voxel `at`, by fourth-order differences along the axes.
bool fit(const TissuePatch& patch, const glm::ivec3& at, Sheet& sheet) noexcept {
  const glm::ivec3 q = at - patch.lo;
  const std::ptrdiff_t step[3] = {static_cast<std::ptrdiff_t>(patch.n) * patch.n, patch.n, 1};
  const float* f = patch.distance.data() + patch.at(q.x, q.y, q.z);
  const double value = f[0];
  dvec3 g;
  glm::dmat3 H;
  double rough = 0;  // largest third or fourth difference of the samples
  for (int i = 0; i < 3; ++i) {
    const std::ptrdiff_t s = step[i];
    const double a = f[-2 * s], b = f[-s], c = f[s], d = f[2 * s];
    g[i] = (8 * (c - b) - (d - a)) / 12;
    H[i][i] = (16 * (b + c) - (a + d) - 30 * value) / 12;
    rough = std::max({rough, std::abs(d - a - 2 * (c - b)), std::abs(a + d - 4 * (b + c) + 6 * value)});
    for (int j = 0; j < i; ++j) {
      const std::ptrdiff_t t = step[j];
      H[i][j] = H[j][i] = (f[s + t] - f[s - t] - f[t - s] + f[-s - t]) / 4.0;
    }
  }
  const double slope = glm::length(g);
  if (std::abs(slope - 1) > C::gradient_tolerance) return false;
  const dvec3 n = g / slope, u = across(n), v = glm::cross(n, u);
  const dvec3 Hu = H * u, Hv = H * v;
  const double uu = glm::dot(u, Hu), uv = glm::dot(u, Hv), vv = glm::dot(v, Hv);
  const double mean = (uu + vv) / 2, along = (uu - vv) / 2, half = std::sqrt(along * along + uv * uv);
  // Converts curvatures of the level set through the voxel to those of the tissue's surface, parallel to it.
  const auto at_surface = [&](double k) { return k / (1 - k * value); };
  const double most = std::max(std::abs(mean + half), std::abs(mean - half));
  if (most > C::max_curvature || rough > C::rough + C::curved_roughness * most * most) return false;
  sheet.n = n;
  sheet.x = dvec3(at) - value * n;
  // Eigenvector of the larger curvature. Of two formulas, uses the one that subtracts no nearly equal numbers.
  sheet.e1 = half < 1e-9 ? u : glm::normalize(along > 0 ? (along + half) * u + uv * v : uv * u + (half - along) * v);
  sheet.e2 = glm::cross(n, sheet.e1);
  sheet.k1 = at_surface(mean + half), sheet.k2 = at_surface(mean - half);
  // A curved fit is wrong if its samples belong to two smooth surfaces, so it is compared with more samples.
  return most < C::curved || off_samples(f, step, at, sheet) < C::residual;
}

/// How far the samples that fit() uses extend from their centre in the direction of the unit vector n, voxels.
double extent(const dvec3& n) noexcept {
  const dvec3 a = glm::abs(n);
  return std::max({2 * a.x, 2 * a.y, 2 * a.z, a.x + a.y, a.y + a.z, a.x + a.z});
}

/// A sheet (smooth surface) that was fitted beside the crease. `at`: voxel at the centre of its samples; `along`: unit
/// vector along the sheet away from the crease.
struct Fitted {
  Sheet sheet;
  dvec3 at{0}, along{0};
};

/// Fits a sheet (smooth surface) `farther` voxels from a surface point, in the direction `away` along the surface.
bool fit_beyond(const TissuePatch& patch, const Landing& place, const dvec3& away, double farther,
                Fitted& fitted) noexcept {
  const dvec3 along = away - glm::dot(away, place.n) * place.n;
  const double length = glm::length(along);
  if (length < 1e-3) return false;
  fitted.along = along / length;
  const glm::ivec3 at(glm::floor(place.x + farther * fitted.along + C::height * place.n + 0.5));
  fitted.at = dvec3(at);
  return patch.holds(fitted.at, 0) && fit(patch, at, fitted.sheet) &&
         glm::dot(fitted.sheet.n, place.n) > C::same_normal;
}
bool fit_beyond(const TissuePatch& patch, const Landing& place, const dvec3& away, Fitted& fitted) noexcept {
  return std::ranges::any_of(C::farther,
                             [&](double farther) { return fit_beyond(patch, place, away, farther, fitted); });
}

/// A surface point beside the crease. `group`: index of the sheet (smooth surface) that was fitted there, or -1.
struct Place {
  Landing at;
  bool landed = false;
  Fitted fitted;
  int group;
};

/// Searches a surface point in each direction around the crease at x. Where it finds none, it starts again lower down.
void search_around(const TissuePatch& patch, const dvec3& x, const dvec3& n, double aside,
                   Place (&around)[C::directions]) noexcept {
  const dvec3 u = across(n), v = glm::cross(n, u);
  for (int i = 0; i < C::directions; ++i) {
    const double a = 2 * kPi * i / C::directions;
    const dvec3 d = std::cos(a) * u + std::sin(a) * v;
    const auto from = [&](const dvec3& start) {
      return land(patch, start, around[i].at) && glm::length(around[i].at.x - x) > C::min_aside;
    };
    around[i].landed = from(x + aside * d) || from(x + C::down * aside * (d - n));
    around[i].group = -1;
  }
}

/// The smooth surfaces that meet at a crease, each with the first sheet (quadratic function) that was fitted to it.
struct Groups {
  int count = 0;
  const Fitted* first[Crease::kMost] = {};

  double above(const dvec3& p) const noexcept {
    double most = -1e300;
    for (int k = 0; k < count; ++k) most = std::max(most, first[k]->sheet.distance(p));
    return most;
  }
  /// Direction at point p along the sheet (smooth surface) number `except`, whose normal is n, away from all others.
  dvec3 away(const dvec3& p, const dvec3& n, int except) const noexcept {
    dvec3 sum(0), other;
    for (int k = 0; k < count; ++k) {
      if (k == except) continue;
      first[k]->sheet.distance(p, other);
      const dvec3 along = glm::dot(other, n) * n - other;
      sum += along / std::max(glm::length(along), 1e-3);
    }
    return sum;
  }
  /// Adds a point to the sheet on which it lies, or begins a new sheet. Returns false if there are too many sheets.
  bool add(Place& place) noexcept {
    for (place.group = 0; place.group < count; ++place.group) {
      dvec3 n;
      const double above = first[place.group]->sheet.distance(place.fitted.sheet.x, n);
      if (std::abs(above) < C::same_sheet && glm::dot(n, place.fitted.sheet.n) > C::same_sheet_normal) return true;
    }
    if (count == Crease::kMost) return false;
    first[count++] = &place.fitted;
    return true;
  }
};

/// Fits the sheet `own` (smooth surface) at `place`. If accepts() refuses the fit, tries farther from the other sheets.
template <class Accepts>
bool fit_away(const TissuePatch& patch, Landing place, const Groups& groups, int own, Fitted& fitted,
              Accepts&& accepts) noexcept {
  for (int step = 0; step < C::away_steps; ++step) {
    const dvec3 away = groups.away(place.x, place.n, own);
    for (const double farther : C::farther) {
      if (fit_beyond(patch, place, away, farther, fitted) && accepts(fitted)) return true;
      if (step > 0) break;
    }
    const dvec3 along = away - glm::dot(away, place.n) * place.n;
    if (glm::length(along) < 1e-3 || !land(patch, place.x + C::away_step * glm::normalize(along), place)) return false;
  }
  return false;
}

/// Fits a sheet (smooth surface) at each point, and finds which points lie on the same sheet. Returns false if there
/// are not two or three sheets.
bool group(const TissuePatch& patch, const dvec3& x, Place (&around)[C::directions], Groups& groups) noexcept {
  for (Place& place : around) {
    if (place.landed && fit_beyond(patch, place.at, place.at.x - x, place.fitted) && !groups.add(place)) return false;
  }
  if (groups.count < 2) return false;
  // A point on the inner side of both smooth surfaces, or whose normal is parallel to their intersection line, lies on
  // a third smooth surface. This surface is fitted at a larger distance from the first two.
  const dvec3 line = glm::normalize(glm::cross(groups.first[0]->sheet.n, groups.first[1]->sheet.n));
  for (Place& place : around) {
    if (!place.landed || place.group >= 0 || groups.count == Crease::kMost) continue;
    if (groups.above(place.at.x) > -C::missed_below && std::abs(glm::dot(place.at.n, line)) < C::along_line) continue;
    if (fit_away(patch, place.at, groups, -1, place.fitted, [](const Fitted&) { return true; })) {
      groups.add(place);
    }
  }
  return true;
}

/// Smallest distance between the samples of a fit and samples that belong to other smooth surfaces, voxels.
double clearance(const Fitted& fitted, const dvec3& x, const Groups& groups, int own) noexcept {
  double least = glm::dot(fitted.at - x, fitted.along) - extent(fitted.along);
  for (int k = 0; k < groups.count; ++k) {
    if (k == own) continue;
    const dvec3& n = fitted.sheet.n;
    dvec3 other;
    const double over = glm::dot(fitted.at - fitted.sheet.x, n) - groups.first[k]->sheet.distance(fitted.at, other);
    const double apart = glm::length(n - other);
    least = std::min(least, over / apart - extent((n - other) / apart));
  }
  return least;
}

/// Of the fits of the sheet `own` whose samples belong to no other sheet, chooses the fit nearest to the crease.
bool choose(const TissuePatch& patch, const dvec3& x, const Place (&around)[C::directions], const Groups& groups,
            int own, Sheet& sheet) noexcept {
  double nearest = 1e300;
  const auto try_fit = [&](const Fitted& fitted) {
    const double distance = glm::length(fitted.at - x);
    if (distance < nearest && clearance(fitted, x, groups, own) > C::clear) nearest = distance, sheet = fitted.sheet;
    return nearest < 1e300;
  };
  for (const Place& place : around) {
    if (place.group == own) try_fit(place.fitted);
  }
  Fitted beyond;
  for (const Place& place : around) {
    if (place.group == own && nearest == 1e300) fit_away(patch, place.at, groups, own, beyond, try_fit);
  }
  return nearest < 1e300;
}

}  // namespace

double Sheet::distance(const dvec3& p) const noexcept {
  const dvec3 d = p - x;
  double root;
  return from_circle(glm::dot(d, e1), from_circle(glm::dot(d, e2), glm::dot(d, n), k2, root), k1, root);
}

double Sheet::distance(const dvec3& p, dvec3& gradient, Bend& bend) const noexcept {
  const dvec3 d = p - x;
  const double u = glm::dot(d, e1), v = glm::dot(d, e2), w = glm::dot(d, n);
  double root1, root2;
  const double height = from_circle(v, w, k2, root2), result = from_circle(u, height, k1, root1);
  const double inverse1 = 1 / root1, inverse2 = 1 / root2;
  const double du = k1 * u * inverse1, raised = (1 + k1 * height) * inverse1;
  const double dv = k2 * v * inverse2, dw = (1 + k2 * w) * inverse2;
  const dvec3 up = dv * e2 + dw * n;
  gradient = du * e1 + raised * up;
  bend = {{raised * e1 - du * up, dw * e2 - dv * n}, {k1 * inverse1, raised * k2 * inverse2}};
  return result;
}

double Sheet::distance(const dvec3& p, dvec3& gradient) const noexcept {
  Bend unused;
  return distance(p, gradient, unused);
}

double Crease::above(const dvec3& p) const noexcept {
  double most = -1e300;
  for (int i = 0; i < count; ++i) most = std::max(most, sheet[i].distance(p));
  return most;
}

bool Crease::onto_line(int i, int j, dvec3& x, dvec3 (&n)[2]) const noexcept {
  for (int step = 0; step < C::newton_steps; ++step) {
    const double a = sheet[i].distance(x, n[0]), b = sheet[j].distance(x, n[1]);
    const double c = glm::dot(n[0], n[1]), det = 1 - c * c;
    if (det < C::min_angle) return false;
    x -= ((a - c * b) / det) * n[0] + ((b - c * a) / det) * n[1];
    if (std::max(std::abs(a), std::abs(b)) < C::last_step) return true;
  }
  return false;
}

bool Crease::onto_corner(dvec3& x, dvec3 (&n)[3]) const noexcept {
  for (int step = 0; step < C::newton_steps; ++step) {
    dvec3 above;
    for (int i = 0; i < 3; ++i) above[i] = sheet[i].distance(x, n[i]);
    if (std::max({std::abs(above.x), std::abs(above.y), std::abs(above.z)}) < C::converged) return true;
    const glm::dmat3 rows = glm::transpose(glm::dmat3(n[0], n[1], n[2]));
    if (std::abs(glm::determinant(rows)) < C::min_angle) return false;
    x -= glm::inverse(rows) * above;
  }
  return false;
}

namespace {

/// Returns true if the sample at `at` agrees with the smooth surfaces of the crease.
bool agrees(const TissuePatch& patch, const dvec3& at, const Crease& crease, double tolerance) noexcept {
  return patch.holds(at, 0) && std::abs(sample_linear(patch, at) - crease.above(at)) < tolerance;
}

/// Returns true if the samples in the tissue around x agree with the smooth surfaces of the crease.
bool agrees_around(const TissuePatch& patch, const dvec3& x, const Crease& crease) noexcept {
  const dvec3 centre = glm::floor(x + 0.5);
  for (int i = 0; i < 27; ++i) {
    const dvec3 p = centre + C::around * dvec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const double above = crease.above(p);
    if (above < C::shallowest && above > -C::deepest && !agrees(patch, p, crease, C::around_agrees)) return false;
  }
  return true;
}

bool find_sheets(const TissuePatch& patch, const dvec3& x, const dvec3& n, double aside, Crease& crease) noexcept {
  Place around[C::directions];
  search_around(patch, x, n, aside, around);
  Groups groups;
  if (!group(patch, x, around, groups)) return false;
  crease.count = 0;
  for (int k = 0; k < groups.count; ++k)
    crease.count += choose(patch, x, around, groups, k, crease.sheet[crease.count]);
  const auto near = [&](const Sheet& sheet) { return std::abs(sheet.distance(x)) < C::near_sheet; };
  if (std::count_if(crease.sheet, crease.sheet + crease.count, near) < 2) return false;
  for (int i = 0; i < crease.count; ++i) {
    for (int j = 0; j < i; ++j) {
      const Sheet &a = crease.sheet[i], &b = crease.sheet[j];
      dvec3 on = x, n_ab[2];
      if (std::max(a.distance(b.x), b.distance(a.x)) > -C::convex) return false;
      // A shallow edge needs no crease, because interpolation is accurate there.
      if (!crease.onto_line(i, j, on, n_ab) || glm::dot(n_ab[0], n_ab[1]) > C::shallow) return false;
    }
  }
  if (!agrees_around(patch, x, crease)) return false;
  // A point far below the fitted surfaces may be inexact (sharp ridge). If the sample below it disagrees: no crease.
  return std::ranges::none_of(around, [&](const Place& place) {
    if (!place.landed || crease.above(place.at.x) > -C::missed_below) return false;
    const dvec3 below = glm::floor(place.at.x - C::below * place.at.n + 0.5);
    return !agrees(patch, below, crease, C::missed_by);
  });
}

/// Returns false if a third smooth surface cuts, near x, the line where the two surfaces of the crease meet. `along`:
/// the line's direction at x.
bool line_goes_on(const TissuePatch& patch, const dvec3& x, const dvec3& along, const Crease& crease) noexcept {
  for (const double way : {-C::ahead, C::ahead}) {
    dvec3 p = x + way * along, n[2];
    if (!crease.onto_line(0, 1, p, n)) return false;
    const dvec3 below = glm::floor(p - C::below * glm::normalize(n[0] + n[1]) + 0.5);
    if (!agrees(patch, below, crease, C::line_agrees)) return false;
  }
  return true;
}

/// Fits the sheets (smooth surfaces) of an edge or rim again, near its point x. Returns false if that fails.
bool follow(const TissuePatch& patch, const dvec3& x, Crease& crease) noexcept {
  if (crease.count != 2) return false;
  Fitted known[Crease::kMost];
  Groups groups;
  for (; groups.count < crease.count; ++groups.count) {
    known[groups.count].sheet = crease.sheet[groups.count];
    groups.first[groups.count] = &known[groups.count];
  }
  double height[2];
  dvec3 n[2];
  for (int k = 0; k < 2; ++k) height[k] = crease.sheet[k].distance(x, n[k]);
  Crease fresh = crease;
  for (int k = 0; k < 2; ++k) {
    const Landing on{x - height[k] * n[k], n[k]};
    const auto fits = [&](double farther) {
      Fitted fitted;
      if (!fit_beyond(patch, on, -n[1 - k], farther, fitted) || std::abs(fitted.sheet.distance(on.x)) > C::same_sheet ||
          clearance(fitted, x, groups, k) < C::clear)
        return false;
      fresh.sheet[k] = fitted.sheet;
      return true;
    };
    if (!std::ranges::any_of(C::aside_followed, fits)) return false;
  }
  if (!line_goes_on(patch, x, glm::normalize(glm::cross(n[0], n[1])), fresh)) return false;
  crease = fresh;
  return true;
}

}  // namespace

const Crease* KnownCreases::find(const TissuePatch& patch, const dvec3& x) noexcept {
  Known* const near =
      std::find_if(known_, known_ + count_, [&](const Known& known) { return glm::length(known.x - x) < C::followed; });
  if (near == known_ + count_) return nullptr;
  if (glm::length(near->x - x) > C::reused) {
    if (!follow(patch, x, near->crease)) return nullptr;
    near->x = x;
  }
  if (near != known_) std::rotate(known_, near, near + 1), touched = x, slid = dvec3(0), room_ = 0;
  return &known_[0].crease;
}

void KnownCreases::add(const dvec3& x, const Crease& crease) noexcept {
  count_ = std::min(count_ + 1, kMost);
  std::move_backward(known_, known_ + count_ - 1, known_ + count_);
  known_[0] = {x, crease};
  touched = x, slid = dvec3(0);
  room_ = 0;
}

void KnownCreases::add_none(const dvec3& x, const dvec3& n) noexcept {
  none_[none_count_++ % kMaxNone] = {x, n};
}

bool KnownCreases::is_none(const dvec3& x, const dvec3& n) const noexcept {
  return std::any_of(none_, none_ + std::min(none_count_, kMaxNone), [&](const auto& none) {
    return glm::length(none.x - x) < C::none_within && glm::dot(none.n, n) > C::none_along;
  });
}

bool is_sharp_at(const TissuePatch& patch, const dvec3& x) noexcept {
  if (!patch.holds(x, 1)) return false;
  const glm::ivec3 q = glm::ivec3(glm::floor(x)) - patch.lo;
  const float* f = patch.distance.data() + patch.at(q.x, q.y, q.z);
  for (const std::ptrdiff_t s :
       {static_cast<std::ptrdiff_t>(patch.n) * patch.n, static_cast<std::ptrdiff_t>(patch.n), std::ptrdiff_t{1}}) {
    const auto bend = [&](std::ptrdiff_t i) { return f[(i - 1) * s] - 2 * f[i * s] + f[(i + 1) * s]; };
    const float most = std::max({bend(-1), bend(0), bend(1), bend(2)});
    if (most > C::max_curvature || most - std::min(bend(-2), bend(3)) > C::sharp) return true;
  }
  return false;
}

bool find_crease(const TissuePatch& patch, const dvec3& x, const dvec3& n, Crease& crease) noexcept {
  return std::ranges::any_of(C::aside, [&](double aside) { return find_sheets(patch, x, n, aside, crease); });
}

}  // namespace typodont::haptics
