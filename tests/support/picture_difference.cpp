#include "tests/support/picture_difference.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>

#include "engine/base/units.h"
#include "engine/render/srgb.h"

namespace typodont::render {

namespace {

// Linear sRGB to CIE XYZ (IEC 61966-2-1), by columns.
const glm::dmat3 kXyzOfRgb{0.4124564, 0.2126729, 0.0193339, 0.3575761, 0.7151522,
                           0.1191920, 0.1804375, 0.0721750, 0.9503041};
const dvec3 kWhite = kXyzOfRgb * dvec3(1);

}  // namespace

dvec3 lab_of_linear(const dvec3& rgb) {
  const dvec3 xyz = kXyzOfRgb * rgb / kWhite;
  const auto f = [](double t) {
    constexpr double kBreak = 6.0 / 29;
    return t > kBreak * kBreak * kBreak ? std::cbrt(t) : t / (3 * kBreak * kBreak) + 4.0 / 29;
  };
  const double x = f(xyz.x), y = f(xyz.y), z = f(xyz.z);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

namespace {

dvec3 linear_at(const Picture& picture, int x, int y) {
  const std::uint8_t* const p = picture.at(x, y);
  static const std::array<double, 256> table = [] {
    std::array<double, 256> t{};
    for (std::size_t i = 0; i < t.size(); ++i) t[i] = linear_light(dvec3(static_cast<double>(i) / 255)).x;
    return t;
  }();
  return {table[p[0]], table[p[1]], table[p[2]]};
}

/// One number per pixel.
struct Plane {
  glm::ivec2 size{0};
  std::vector<double> values;

  explicit Plane(glm::ivec2 s) : size(s), values(static_cast<std::size_t>(s.x) * static_cast<std::size_t>(s.y)) {}
  double& at(int x, int y) {
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(x)];
  }
  double at(int x, int y) const { return const_cast<Plane*>(this)->at(x, y); }
};

/// Along one axis, offsets -r .. r.
using Weights = std::vector<double>;

Weights weights(int radius, const std::function<double(double)>& of) {
  Weights w;
  for (int i = -radius; i <= radius; ++i) w.push_back(of(i));
  return w;
}

double sum(const Weights& w) {
  double s = 0;
  for (const double v : w) s += v;
  return s;
}

/// Beyond the edge, the edge's values.
Plane filtered(const Plane& in, const Weights& along_x, const Weights& along_y) {
  const int r = static_cast<int>(along_x.size()) / 2;
  Plane half(in.size), out(in.size);
  for (int y = 0; y < in.size.y; ++y)
    for (int x = 0; x < in.size.x; ++x)
      for (int k = -r; k <= r; ++k)
        half.at(x, y) += along_x[static_cast<std::size_t>(k + r)] * in.at(std::clamp(x + k, 0, in.size.x - 1), y);
  for (int y = 0; y < in.size.y; ++y)
    for (int x = 0; x < in.size.x; ++x)
      for (int k = -r; k <= r; ++k)
        out.at(x, y) += along_y[static_cast<std::size_t>(k + r)] * half.at(x, std::clamp(y + k, 0, in.size.y - 1));
  return out;
}

/// a1, a2 and widths b1, b2 (deg²) of two Gaussians (Andersson et al. 2020, Table 1).
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> kSensitivity{
    {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};

Plane seen(const Plane& in, const Sensitivity& s, double pixels_per_degree) {
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * kPi * kPi)) * pixels_per_degree));
  Plane out(in.size);
  double total = 0;
  for (const auto& [a, b] : {std::pair{s.a1, s.b1}, std::pair{s.a2, s.b2}}) {
    if (a == 0) continue;
    const Weights w = weights(radius, [&](double i) {
      const double x = i / pixels_per_degree;
      return std::exp(-kPi * kPi * x * x / b);
    });
    const double amplitude = a * std::sqrt(kPi / b);
    const Plane part = filtered(in, w, w);
    for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] += amplitude * part.values[i];
    total += amplitude * sum(w) * sum(w);
  }
  for (double& v : out.values) v /= total;
  return out;
}

/// Y Cx Cz, linear in light.
std::array<Plane, 3> opponent(const Picture& picture) {
  std::array<Plane, 3> planes{Plane(picture.size), Plane(picture.size), Plane(picture.size)};
  for (int y = 0; y < picture.size.y; ++y)
    for (int x = 0; x < picture.size.x; ++x) {
      const dvec3 xyz = kXyzOfRgb * linear_at(picture, x, y) / kWhite;
      planes[0].at(x, y) = 116 * xyz.y - 16;
      planes[1].at(x, y) = 500 * (xyz.x - xyz.y);
      planes[2].at(x, y) = 200 * (xyz.y - xyz.z);
    }
  return planes;
}

dvec3 linear_of_opponent(const dvec3& o) {
  const double y = (o.x + 16) / 116;
  return glm::inverse(kXyzOfRgb) * (kWhite * dvec3(y + o.y / 500, y, y - o.z / 200));
}

/// Hunt effect: colours appear stronger in bright light.
dvec3 hunt(const dvec3& lab) {
  return {lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z};
}
double hyab(const dvec3& a, const dvec3& b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

/// Edges (0) and points (1).
std::array<Plane, 2> features(const Plane& achromatic, double pixels_per_degree) {
  constexpr double kWidth = 0.082;  // degrees, of an edge or point
  const double sigma = 0.5 * kWidth * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  const auto bell = [&](double x) { return std::exp(-x * x / (2 * sigma * sigma)); };
  Weights smooth = weights(radius, bell);
  const double whole = sum(smooth);
  for (double& w : smooth) w /= whole;
  // Positive weights sum to 1, negative ones to -1.
  const auto balanced = [](Weights w) {
    double up = 0, down = 0;
    for (const double v : w) (v > 0 ? up : down) += std::abs(v);
    for (double& v : w) v /= v > 0 ? up : down;
    return w;
  };
  const Weights edge = balanced(weights(radius, [&](double x) { return -x * bell(x); }));
  const Weights point = balanced(weights(radius, [&](double x) { return (x * x / (sigma * sigma) - 1) * bell(x); }));
  std::array<Plane, 2> strength{Plane(achromatic.size), Plane(achromatic.size)};
  for (std::size_t f = 0; f < 2; ++f) {
    const Weights& across = f == 0 ? edge : point;
    const Plane x = filtered(achromatic, across, smooth), y = filtered(achromatic, smooth, across);
    for (std::size_t i = 0; i < x.values.size(); ++i) strength[f].values[i] = std::hypot(x.values[i], y.values[i]);
  }
  return strength;
}

}  // namespace

double ciede2000(const dvec3& lab_1, const dvec3& lab_2) {
  const auto seventh = [](double x) { return std::pow(x, 7); };
  const double c_mean = 0.5 * (std::hypot(lab_1.y, lab_1.z) + std::hypot(lab_2.y, lab_2.z));
  const double g = 0.5 * (1 - std::sqrt(seventh(c_mean) / (seventh(c_mean) + seventh(25))));
  const double a1 = (1 + g) * lab_1.y, a2 = (1 + g) * lab_2.y;
  const double c1 = std::hypot(a1, lab_1.z), c2 = std::hypot(a2, lab_2.z);
  const auto hue = [](double a, double b) {  // returns the hue angle in degrees, 0..360
    if (a == 0 && b == 0) return 0.0;
    const double h = std::atan2(b, a) * 180 / kPi;
    return h < 0 ? h + 360 : h;
  };
  const double h1 = hue(a1, lab_1.z), h2 = hue(a2, lab_2.z);
  const bool colorless = c1 * c2 == 0;
  double dh = colorless ? 0 : h2 - h1;
  if (dh > 180) dh -= 360;
  if (dh < -180) dh += 360;
  const double dl = lab_2.x - lab_1.x, dc = c2 - c1;
  const double radians = kPi / 180;
  const double dhue = 2 * std::sqrt(c1 * c2) * std::sin(0.5 * dh * radians);
  const double l = 0.5 * (lab_1.x + lab_2.x), c = 0.5 * (c1 + c2);
  double h = h1 + h2;
  if (!colorless) {
    if (std::abs(h1 - h2) > 180) h += h < 360 ? 360 : -360;
    h *= 0.5;
  }
  const double t = 1 - 0.17 * std::cos((h - 30) * radians) + 0.24 * std::cos(2 * h * radians) +
                   0.32 * std::cos((3 * h + 6) * radians) - 0.20 * std::cos((4 * h - 63) * radians);
  const double turn = 30 * std::exp(-((h - 275) / 25) * ((h - 275) / 25));
  const double rc = 2 * std::sqrt(seventh(c) / (seventh(c) + seventh(25)));
  const double light = (l - 50) * (l - 50);
  const double sl = 1 + 0.015 * light / std::sqrt(20 + light), sc = 1 + 0.045 * c, sh = 1 + 0.015 * c * t;
  const double rt = -std::sin(2 * turn * radians) * rc;
  const double x = dl / sl, y = dc / sc, z = dhue / sh;
  return std::sqrt(std::max(0.0, x * x + y * y + z * z + rt * y * z));
}

double mean_ciede2000(const Picture& a, const Picture& b) {
  assert(a.size == b.size);
  double total = 0;
  for (int y = 0; y < a.size.y; ++y)
    for (int x = 0; x < a.size.x; ++x)
      total += ciede2000(lab_of_linear(linear_at(a, x, y)), lab_of_linear(linear_at(b, x, y)));
  return total / (static_cast<double>(a.size.x) * a.size.y);
}

double mean_flip(const Picture& a, const Picture& b, double pixels_per_degree) {
  assert(a.size == b.size);
  const std::array<std::array<Plane, 3>, 2> pictures{opponent(a), opponent(b)};
  std::array<std::vector<dvec3>, 2> colors;  // as the eye resolves them
  std::array<std::array<Plane, 2>, 2> marks{features(pictures[0][0], pixels_per_degree),
                                            features(pictures[1][0], pixels_per_degree)};
  for (std::size_t p = 0; p < 2; ++p) {
    std::array<Plane, 3> planes = pictures[p];
    for (std::size_t c = 0; c < 3; ++c) planes[c] = seen(planes[c], kSensitivity[c], pixels_per_degree);
    for (std::size_t i = 0; i < planes[0].values.size(); ++i) {
      const dvec3 rgb = linear_of_opponent({planes[0].values[i], planes[1].values[i], planes[2].values[i]});
      colors[p].push_back(hunt(lab_of_linear(glm::clamp(rgb, 0.0, 1.0))));
    }
  }
  constexpr double kColorPower = 0.7, kKnee = 0.4, kAtKnee = 0.95, kFeaturePower = 0.5;
  const double greatest = std::pow(hyab(hunt(lab_of_linear({0, 1, 0})), hunt(lab_of_linear({0, 0, 1}))), kColorPower);
  double total = 0;
  for (std::size_t i = 0; i < colors[0].size(); ++i) {
    const double apart = std::pow(hyab(colors[0][i], colors[1][i]), kColorPower), knee = kKnee * greatest;
    const double color =
        apart < knee ? kAtKnee * apart / knee : kAtKnee + (1 - kAtKnee) * (apart - knee) / (greatest - knee);
    double mark = 0;
    for (std::size_t f = 0; f < 2; ++f)
      mark = std::max(mark, std::abs(marks[0][f].values[i] - marks[1][f].values[i]) / 116);
    total += std::pow(color, 1 - std::pow(mark / std::sqrt(2.0), kFeaturePower));
  }
  return total / static_cast<double>(colors[0].size());
}

}  // namespace typodont::render
