#include "engine/session/cavity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/session/geometry/tetrahedra.h"

namespace typodont::session {

namespace {

// Tissue counts as cut if it was deeper than this below the original surface, voxels.
constexpr double kNewSurface = 0.75;
// A facet is floor if the cosine between its normal and the axis is larger than this.
const double kFloor = std::cos(30 * kPi / 180);
// A facet is wall if the |cosine| between its normal and the axis is smaller than this: inclination below 30°.
constexpr double kWall = 0.5;
// Facets near an edge are not measured: there, the distance field's gradient is shorter than kShortest (on a flat face
// its length is 1) or more than 10° off the normal. Ripples left by a bur also shorten the gradient, so kShortest is
// well below 1.
constexpr double kShortest = 0.8;
const double kOneFace = std::cos(10 * kPi / 180);
// Smallest gradient length from which a wall's inclination is computed. A shorter gradient has samples on both sides of
// an edge.
constexpr double kMinGradient = 0.98;
constexpr double kRounding = 1e-9;  // voxels; distances from the ideal shape that are smaller than this count as 0
// Smallest area of floor and walls that is measured, m².
constexpr double kMinArea = 0.1e-6;
// Share of the smallest and of the largest values, by area, that is left out, because these belong to a face's edges.
constexpr double kTrimmed = 0.1;
// m; no wall thickness is measured above this depth below the original surface, because walls are always thin there.
constexpr double kRim = 1e-3;
// Half the distance over which the gradient of a wall is computed, voxels. Large enough to average out ripples.
constexpr double kAcross = 1.5;
constexpr double kFarthestWall = 5e-3;  // m, upper limit of a wall's thickness
constexpr double kSmoothing = 0.25e-3;  // m, width of the Gaussian that smooths the margin

struct Facet {
  dvec3 p{0};              // voxels, centre of the facet
  dvec3 n{0};              // unit normal, pointing out of the tissue
  double area = 0;         // voxels², area of the facet
  std::size_t inside = 0;  // index of the facet's neighbouring sample inside the tissue
};

double weighted_mean(const std::vector<std::pair<double, double>>& values) {
  double sum = 0, weight = 0;
  for (const auto& [v, w] : values) sum += v * w, weight += w;
  return weight > 0 ? sum / weight : 0;
}

/// Weighted mean of (value, weight) pairs. Leaves out the fraction `trim` of the weight at the low and at the high end.
double trimmed_mean(std::vector<std::pair<double, double>> values, double trim) {
  std::sort(values.begin(), values.end());
  const double total =
      std::accumulate(values.begin(), values.end(), 0.0, [](double s, const auto& v) { return s + v.second; });
  double at = 0, sum = 0, weight = 0;
  for (const auto& [v, w] : values) {
    const double from = std::max(at, trim * total), to = std::min(at + w, (1 - trim) * total);
    if (to > from) sum += v * (to - from), weight += to - from;
    at += w;
  }
  return weight > 0 ? sum / weight : 0;
}

/// Weighted quantile: the smallest value v such that the weights of all values ≤ v sum to `weight`.
double lowest(std::vector<std::pair<double, double>> values, double weight) {
  std::sort(values.begin(), values.end());
  for (const auto& [v, w] : values) {
    weight -= w;
    if (weight <= 0) return v;
  }
  return values.back().first;
}

struct Axes {
  dvec3 u, v, w;  // perpendicular unit vectors; w points out of the opening
};
Axes axes_about(const dvec3& axis) {
  const dvec3 w = glm::normalize(axis);
  const dvec3 other = std::abs(w.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 u = glm::normalize(other - glm::dot(other, w) * w);
  return {u, glm::cross(w, u), w};
}

/// Least-squares plane w = c0 + c1 u + c2 v through facets, weighted by area, in voxels along `axes`. fit_plane()
/// returns false if the facets do not determine a plane.
struct Plane {
  double c0 = 0, c1 = 0, c2 = 0;
};
bool fit_plane(const std::vector<Facet>& facets, const Axes& axes, Plane& plane) {
  double weight = 0, mu = 0, mv = 0, mw = 0;
  for (const Facet& f : facets) {
    weight += f.area;
    mu += f.area * glm::dot(f.p, axes.u);
    mv += f.area * glm::dot(f.p, axes.v);
    mw += f.area * glm::dot(f.p, axes.w);
  }
  mu /= weight, mv /= weight, mw /= weight;
  double uu = 0, uv = 0, vv = 0, uw = 0, vw = 0;
  for (const Facet& f : facets) {
    const double u = glm::dot(f.p, axes.u) - mu, v = glm::dot(f.p, axes.v) - mv, w = glm::dot(f.p, axes.w) - mw;
    uu += f.area * u * u, uv += f.area * u * v, vv += f.area * v * v;
    uw += f.area * u * w, vw += f.area * v * w;
  }
  const double det = uu * vv - uv * uv;
  if (!(det > 1e-6 * weight * weight)) return false;
  plane.c1 = (uw * vv - vw * uv) / det;
  plane.c2 = (vw * uu - uw * uv) / det;
  plane.c0 = mw - plane.c1 * mu - plane.c2 * mv;
  return true;
}

/// Sphere with centre c and radius r. fit_ball() minimises the sum of area × (|p - c|² - r²)² over all facet centres p,
/// in voxels; it returns nothing if the facets do not determine a sphere.
struct Ball {
  dvec3 center;
  double radius;
};
std::optional<Ball> fit_ball(const std::vector<Facet>& facets) {
  double weight = 0;
  dvec3 mean(0);
  for (const Facet& f : facets) weight += f.area, mean += f.area * f.p;
  mean /= weight;
  // For a point q of the sphere and its centre c, both relative to the mean point, |q|² = 2 q·c + k. The equations for
  // c and for the constant k are independent; k is the mean of |q|².
  glm::dmat3 normal(0);
  dvec3 right(0);
  double square = 0;
  for (const Facet& f : facets) {
    const dvec3 q = f.p - mean;
    normal += f.area * glm::outerProduct(q, q);
    right += 0.5 * f.area * glm::dot(q, q) * q;
    square += f.area * glm::dot(q, q);
  }
  const double spread = square / 3;
  // Almost all facets are in one plane, so they determine no sphere.
  if (!(glm::determinant(normal) > 1e-6 * spread * spread * spread)) return std::nullopt;
  const dvec3 c = glm::inverse(normal) * right;
  return Ball{mean + c, std::sqrt(square / weight + glm::dot(c, c))};
}

/// Distance from p along `direction` to the tissue's last point, voxels.
double last_inside(const DenseField& field, const dvec3& p, const dvec3& direction) {
  const double longest = glm::length(dvec3(field.size));
  double last = 0, previous = field.sample(p);
  for (double s = 0.5; s < longest; s += 0.5) {
    const dvec3 q = p + s * direction;
    if (glm::any(glm::lessThan(q, dvec3(0))) || glm::any(glm::greaterThan(q, dvec3(field.size - 1)))) break;
    const double d = field.sample(q);
    if (previous < 0 && d >= 0) last = s - 0.5 + 0.5 * previous / (previous - d);
    previous = d;
  }
  return last;
}

/// The margin: curves where the border of the cut meets the surface before the work, as ordered points in voxels.
std::vector<std::vector<dvec3>> margins(const DenseField& before, const DenseField& after) {
  constexpr double kLevel = 0.5;           // voxels; the margin lies at this depth below the original surface
  using Key = std::array<std::size_t, 4>;  // edge of a triangle: for each end, the indices of two samples
  struct End {
    dvec3 p;
    std::vector<std::size_t> segments;
  };
  std::map<Key, std::size_t> index;
  std::vector<End> ends;
  std::vector<std::array<std::size_t, 2>> segments;
  each_triangle(before, [&](const EdgeTriangle& t) {
    double g[3];
    for (std::size_t k = 0; k < 3; ++k) g[k] = t[k].of(after.distance) - t[k].of(before.distance) - kLevel;
    if ((g[0] > 0) == (g[1] > 0) && (g[1] > 0) == (g[2] > 0)) return;
    std::vector<std::size_t> crossed;
    for (std::size_t k = 0; k < 3; ++k) {
      std::size_t a = k, b = (k + 1) % 3;
      if ((g[a] > 0) == (g[b] > 0)) continue;
      if (std::pair(t[a].i, t[a].j) > std::pair(t[b].i, t[b].j)) std::swap(a, b);
      const Key key{t[a].i, t[a].j, t[b].i, t[b].j};
      const auto [it, fresh] = index.try_emplace(key, ends.size());
      if (fresh) ends.push_back({t[a].p + g[a] / (g[a] - g[b]) * (t[b].p - t[a].p), {}});
      crossed.push_back(it->second);
    }
    if (crossed.size() != 2 || crossed[0] == crossed[1]) return;
    for (const std::size_t e : crossed) ends[e].segments.push_back(segments.size());
    segments.push_back({crossed[0], crossed[1]});
  });

  // Traces open curves first, from one of their ends.
  std::vector<bool> used(segments.size(), false);
  std::vector<std::vector<dvec3>> curves;
  const auto follow = [&](std::size_t start) {
    std::vector<dvec3> curve{ends[start].p};
    std::size_t at = start;
    for (bool on = true; on;) {
      on = false;
      for (const std::size_t s : ends[at].segments) {
        if (used[s]) continue;
        used[s] = true;
        at = segments[s][0] == at ? segments[s][1] : segments[s][0];
        curve.push_back(ends[at].p);
        on = true;
        break;
      }
    }
    if (curve.size() > 1) curves.push_back(std::move(curve));
  };
  for (const std::size_t only : {std::size_t{1}, std::size_t{2}}) {
    for (std::size_t e = 0; e < ends.size(); ++e) {
      if (only == 2 || ends[e].segments.size() == 1) follow(e);
    }
  }
  return curves;
}

/// Mean square distance of a curve from its smoothed copy (Gaussian of width sigma), and the curve's length. Voxels.
std::pair<double, double> roughness(const std::vector<dvec3>& curve, double sigma) {
  double length = 0;
  for (std::size_t i = 1; i < curve.size(); ++i) length += glm::length(curve[i] - curve[i - 1]);
  if (length < 4 * sigma) return {0, 0};
  // Samples the curve at equal distances.
  const auto count = static_cast<std::size_t>(std::ceil(length / 0.5));
  const double step = length / static_cast<double>(count);
  std::vector<dvec3> even;
  double at = 0;
  for (std::size_t i = 1; i < curve.size() && even.size() < count; ++i) {
    const double piece = glm::length(curve[i] - curve[i - 1]);
    while (even.size() < count && static_cast<double>(even.size()) * step <= at + piece) {
      const double s = piece > 0 ? (static_cast<double>(even.size()) * step - at) / piece : 0;
      even.push_back(curve[i - 1] + s * (curve[i] - curve[i - 1]));
    }
    at += piece;
  }
  const bool closed = glm::length(curve.front() - curve.back()) < 1e-9;
  const auto n = static_cast<std::ptrdiff_t>(even.size());
  const auto reach = static_cast<std::ptrdiff_t>(std::ceil(3 * sigma / step));
  double square = 0;
  std::ptrdiff_t counted = 0;
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    if (!closed && (i < reach || i + reach >= n)) continue;
    dvec3 mean(0);
    double weight = 0;
    for (std::ptrdiff_t k = -reach; k <= reach; ++k) {
      const double s = static_cast<double>(k) * step / sigma;
      const double w = std::exp(-0.5 * s * s);
      mean += w * even[static_cast<std::size_t>(((i + k) % n + n) % n)];
      weight += w;
    }
    const dvec3 d = even[static_cast<std::size_t>(i)] - mean / weight;
    square += glm::dot(d, d);
    ++counted;
  }
  return counted > 0 ? std::pair(square / static_cast<double>(counted), length) : std::pair(0.0, 0.0);
}

/// Smallest width of the cavity across its longer axis at height `w` along `axes.w`, without the rounded ends. Voxels.
std::optional<double> narrowest(const DenseField& before, const DenseField& after, const Axes& axes, double w) {
  // Removed area's centre and longer axis, from its moments.
  double count = 0, mu = 0, mv = 0, uu = 0, uv = 0, vv = 0;
  const auto each_removed = [&](auto&& use) {
    for_each_voxel(before.size, [&](int x, int y, int z) {
      const std::size_t i = before.at(x, y, z);
      if (before.distance[i] > -0.5f || after.distance[i] < 0) return;
      const dvec3 p(x, y, z);
      if (std::abs(glm::dot(p, axes.w) - w) <= 1) use(glm::dot(p, axes.u), glm::dot(p, axes.v));
    });
  };
  each_removed([&](double u, double v) { ++count, mu += u, mv += v; });
  if (count < 8) return std::nullopt;
  mu /= count, mv /= count;
  each_removed(
      [&](double u, double v) { uu += (u - mu) * (u - mu), uv += (u - mu) * (v - mv), vv += (v - mv) * (v - mv); });
  const double angle = 0.5 * std::atan2(2 * uv, uu - vv);
  const dvec3 along = std::cos(angle) * axes.u + std::sin(angle) * axes.v;
  const dvec3 across = -std::sin(angle) * axes.u + std::cos(angle) * axes.v;
  const dvec3 center = mu * axes.u + mv * axes.v + w * axes.w;

  // For each cross-section: the widest interval that was tissue, is now empty, and ends at walls on both sides.
  const double reach = glm::length(dvec3(before.size));
  struct Section {
    double s, width;
  };
  std::vector<Section> sections;
  for (double s = -std::floor(reach); s <= reach; s += 0.5) {
    double begin = 0, best = 0, before_last = 0, last = 0;
    bool open = false, walled = false;
    for (double t = -reach; t <= reach; t += 0.5) {
      const dvec3 p = center + s * along + t * across;
      if (glm::any(glm::lessThan(p, dvec3(0))) || glm::any(glm::greaterThan(p, dvec3(before.size - 1)))) {
        open = false;
        continue;
      }
      const double a = after.sample(p), b = before.sample(p);
      if (!open && a >= 0 && b < 0) {
        open = true;
        // The interval begins at a wall if the sample before it was tissue before the work and is tissue after it.
        walled = last < 0 && before_last < 0;
        begin = walled ? t - 0.5 + 0.5 * last / (last - a) : t;
      } else if (open && a < 0) {
        if (walled) best = std::max(best, t - 0.5 + 0.5 * last / (last - a) - begin);
        open = false;
      } else if (open && b >= 0) {
        open = false;  // the interval ends in open air
      }
      last = a, before_last = b;
    }
    if (best > 0) sections.push_back({s, best});
  }
  if (sections.empty()) return std::nullopt;
  const double half = 0.5 * std::max_element(sections.begin(), sections.end(), [](auto& a, auto& b) {
                              return a.width < b.width;
                            })->width;
  std::optional<double> narrow;
  for (const Section& section : sections) {
    if (section.s < sections.front().s + half || section.s > sections.back().s - half) continue;
    if (!narrow || section.width < *narrow) narrow = section.width;
  }
  return narrow ? narrow : 2 * half;
}

CavityReference without_measures(const Preparation& in) {
  CavityReference g{TrueDistances(in.before), {}, {}, {}, {}};
  if (!in.ideal.distance.empty()) g.ideal.emplace(in.ideal);
  g.pulp.resize(in.tissue.size());
  bool any = false;
  for (std::size_t i = 0; i < in.tissue.size(); ++i) {
    g.pulp[i] = in.tissue[i] == Tissue::kPulp && in.before.distance[i] < 0;
    any = any || g.pulp[i];
  }
  if (any) g.to_pulp = nearest_marked(in.before.size, g.pulp);
  return g;
}

/// Marks air that is connected to the border of the box. All other air is pores.
std::vector<bool> open_air(const DenseField& field) {
  std::vector<bool> open(field.distance.size());
  std::vector<glm::ivec3> front;
  const auto reach = [&](const glm::ivec3& p) {
    if (!in_grid(p, field.size)) return;
    const std::size_t i = field.at(p.x, p.y, p.z);
    if (open[i] || field.distance[i] < 0) return;
    open[i] = true;
    front.push_back(p);
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (const int side : {0, field.size[axis] - 1}) {
      glm::ivec3 p;
      p[axis] = side;
      for (p[a] = 0; p[a] < field.size[a]; ++p[a])
        for (p[b] = 0; p[b] < field.size[b]; ++p[b]) reach(p);
    }
  }
  while (!front.empty()) {
    const glm::ivec3 p = front.back();
    front.pop_back();
    for (int axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        glm::ivec3 to = p;
        to[axis] += step;
        reach(to);
      }
    }
  }
  return open;
}

CavityMeasures measure(const Preparation& in, const CavityReference& known, const DenseField& after) {
  CavityMeasures m;
  m.has_ideal = !in.ideal.distance.empty();
  const double h = in.frame.voxel, h2 = h * h, h3 = h2 * h;
  const TrueDistances& before = known.before;
  const std::size_t count = after.distance.size();

  // Volumes are sums, over all voxels, of the fraction of the voxel that is inside each surface.
  double kept_removed = 0;
  bool any_kept = false;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = fraction_inside(static_cast<double>(after.distance[i])),
                 b = fraction_inside(static_cast<double>(in.before.distance[i]));
    if (m.has_ideal) {
      const double c = fraction_inside(static_cast<double>(in.ideal.distance[i]));
      m.wanted += std::abs(b - c);
      m.done += c < b ? std::clamp(b - a, 0.0, b - c) : std::clamp(a - b, 0.0, c - b);
      m.over_volume += std::max(0.0, c - a);
      m.under_volume += std::max(0.0, a - c);
    }
    if (!in.keep.empty() && in.keep[i]) {
      any_kept |= b > 0;
      kept_removed += std::max(0.0, b - a);
    }
  }
  m.wanted *= h3, m.done *= h3, m.over_volume *= h3, m.under_volume *= h3;
  if (any_kept) m.kept_removed = kept_removed * h3;

  // Leaves out facets inside pores, because no probe can reach them. The measured volumes include the pores.
  std::vector<Facet> fresh, floor, walls;
  const Axes axes = axes_about(in.axis_W);
  const std::vector<bool> open = open_air(after);
  double contour_square = 0, contour_area = 0;
  each_triangle(after, [&](const EdgeTriangle& t) {
    if (!open[after.distance[t[0].i] < 0 ? t[0].j : t[0].i]) return;
    Facet f;
    const dvec3 normal = glm::cross(t[1].p - t[0].p, t[2].p - t[0].p);
    f.area = 0.5 * glm::length(normal);
    if (!(f.area > 0)) return;
    f.n = normal / (2 * f.area);
    f.p = (t[0].p + t[1].p + t[2].p) / 3.0;
    f.inside = after.distance[t[0].i] < 0 ? t[0].i : t[0].j;
    double old = 0, off = 0;
    for (const EdgePoint& e : t) {
      old += e.of(before) / 3;
      if (!m.has_ideal) continue;
      double d = e.of(*known.ideal);
      if (std::abs(d) < kRounding) d = 0;
      off += d / 3;
      Place& place = d < 0 ? m.over : m.under;
      if (std::abs(d) * h > place.depth) place = {std::abs(d) * h, in.frame.to_world(e.p)};
    }
    // For `contour` (rms distance from the target shape), only facets count that are more than kNewSurface from the
    // original surface or the target shape. A facet is new if it is deeper than kNewSurface below the original surface.
    if (m.has_ideal && (std::abs(old) > kNewSurface || std::abs(off) > kNewSurface)) {
      contour_square += f.area * off * off;
      contour_area += f.area;
    }
    if (old > -kNewSurface) return;
    fresh.push_back(f);
    // At the floor's edge, the gradient depends on floor and wall, so facets there are left out.
    const dvec3 g = after.gradient(f.p);
    if (glm::dot(f.n, g) < std::max(kShortest, kOneFace * glm::length(g))) return;
    const double lean = glm::dot(f.n, axes.w);
    if (lean > kFloor) floor.push_back(f);
    if (std::abs(lean) < kWall) walls.push_back(f);
  });
  if (contour_area > 0) m.contour = std::sqrt(contour_square / contour_area) * h;
  const auto area_of = [&](const std::vector<Facet>& facets) {
    return h2 * std::accumulate(facets.begin(), facets.end(), 0.0, [](double s, const Facet& f) { return s + f.area; });
  };
  m.cut_area = area_of(fresh);
  if (m.cut_area >= kMinArea) {
    dvec3 out(0);
    for (const Facet& f : fresh) out += f.area * f.n;
    const auto ball = fit_ball(fresh);
    if (ball && glm::length(out) > 0) {
      m.cup = {in.frame.to_world(ball->center), ball->radius * h, glm::normalize(out)};
    }
  }

  // Measures the floor of the cavity.
  double floor_height = 0;
  if (area_of(floor) >= kMinArea) {
    std::vector<std::pair<double, double>> depths, heights;
    for (const Facet& f : floor) {
      depths.emplace_back(last_inside(in.before, f.p, axes.w), f.area);
      heights.emplace_back(glm::dot(f.p, axes.w), f.area);
    }
    m.floor_depth = trimmed_mean(depths, kTrimmed) * h;
    floor_height = weighted_mean(heights);
    Plane plane;
    if (fit_plane(floor, axes, plane)) {
      const double slope = 1 / std::sqrt(1 + plane.c1 * plane.c1 + plane.c2 * plane.c2);
      double square = 0, area = 0;
      for (const Facet& f : floor) {
        const double off =
            (glm::dot(f.p, axes.w) - plane.c0 - plane.c1 * glm::dot(f.p, axes.u) - plane.c2 * glm::dot(f.p, axes.v)) *
            slope;
        square += f.area * off * off;
        area += f.area;
      }
      m.floor_flatness = std::sqrt(square / area) * h;
      m.floor_tilt = std::acos(std::min(1.0, slope));
    }
    const auto width = narrowest(in.before, after, axes, floor_height + 0.5 * *m.floor_depth / h);
    if (width) m.isthmus = *width * h;
  }

  // Measures the walls of the cavity.
  if (area_of(walls) >= kMinArea) {
    std::vector<std::pair<double, double>> leans, depths, thickness;
    std::vector<dvec3> thick_at;
    for (const Facet& f : walls) {
      const dvec3 g = after.gradient(f.p, kAcross);
      // If the gradient is shorter than kMinGradient, samples beyond an edge have changed it; then it is not used.
      if (glm::length(g) >= kMinGradient)
        leans.emplace_back(std::asin(std::clamp(glm::dot(g, axes.w) / glm::length(g), -1.0, 1.0)), f.area);
      depths.emplace_back(-before.sample(f.p), f.area);
      if (last_inside(in.before, f.p, axes.w) * h < kRim) continue;
      // Thickness of the hard tissue from the wall to the open air behind it. If pulp lies between wall and air, no
      // thickness is measured.
      double last = 0;
      for (double s = 1; s * h < kFarthestWall; s += 0.5) {
        const dvec3 q = f.p - s * f.n;
        const glm::ivec3 v(glm::round(q));
        if (!in_grid(v, after.size)) break;
        const double d = after.sample(q);
        if (d >= 0) {
          thickness.emplace_back(std::max(0.0, s - (last < 0 ? 0.5 * d / (d - last) : 0.0)), f.area);
          thick_at.push_back(f.p);
          break;
        }
        if (in.tissue[after.at(v.x, v.y, v.z)] == Tissue::kPulp) break;
        last = d;
      }
    }
    if (!leans.empty()) m.taper = 2 * trimmed_mean(leans, kTrimmed);
    m.wall_depth = trimmed_mean(depths, kTrimmed) * h;
    if (!thickness.empty()) {
      const double thinnest = lowest(thickness, std::min(kMinArea / h2, 0.5 * area_of(walls) / h2));
      m.wall_thickness = thinnest * h;
      const auto found =
          std::find_if(thickness.begin(), thickness.end(), [&](const auto& t) { return t.first == thinnest; });
      m.thinnest_W = in.frame.to_world(thick_at[static_cast<std::size_t>(found - thickness.begin())]);
    }
  }

  // Measures the roughness of the cavity's margin, where the cavity meets the surface before the work.
  double square = 0, length = 0;
  for (const auto& curve : margins(in.before, after)) {
    const auto [mean_square, its_length] = roughness(curve, kSmoothing / h);
    square += mean_square * its_length;
    length += its_length;
  }
  if (length > 0) m.margin_roughness = std::sqrt(square / length) * h;

  // Measures the smallest distance from the cavity to the pulp.
  if (!known.to_pulp.empty()) {
    double exposed = 0;
    for (const Facet& f : fresh) {
      if (known.pulp[f.inside]) exposed += f.area;
    }
    m.pulp_exposed = exposed * h2;
    double nearest = kPulpReach / h;
    for (const Facet& f : fresh) {
      const dvec3 center(voxel_at(known.to_pulp[f.inside], after.size));
      const double distance = std::max(0.0, glm::length(f.p - center) - 0.5);
      if (distance < nearest) nearest = distance, m.nearest_pulp_W = in.frame.to_world(f.p);
    }
    m.pulp_distance = nearest * h;
  }
  return m;
}

}  // namespace

CavityReference cavity_reference(const Preparation& preparation) {
  CavityReference reference = without_measures(preparation);
  if (!preparation.ideal.distance.empty()) reference.measures = measure(preparation, reference, preparation.ideal);
  return reference;
}

CavityAndIdeal measure_against_ideal(const Preparation& preparation, const CavityReference& reference) {
  CavityAndIdeal both{measure(preparation, reference, preparation.after), reference.measures};
  if (!both.ideal || !both.ideal->cup) return both;
  both.ideal->cup_offset = both.ideal->cup_tilt = 0;
  if (const auto& cup = both.result.cup) {
    both.result.cup_offset = glm::distance(cup->center_W, both.ideal->cup->center_W);
    both.result.cup_tilt = std::acos(std::clamp(glm::dot(cup->axis_W, both.ideal->cup->axis_W), -1.0, 1.0));
  }
  return both;
}

}  // namespace typodont::session
