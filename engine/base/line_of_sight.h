// Where an eye sees a pixel of a panel, directly or in a mirror. Panel and mirror may be slightly curved. Metres, one
// frame. T: double, or a dual number with derivatives. Any thread.
#pragma once

#include <array>
#include <cmath>

#include "engine/base/pose.h"

namespace typodont::sight {

/// A vector of any scalar type; GLM's vectors need plain numbers.
template <class T>
struct Vec {
  T x{}, y{}, z{};
};
template <class T>
Vec<T> vec(const dvec3& v) {
  return {T(v.x), T(v.y), T(v.z)};
}
inline dvec3 plain(const Vec<double>& v) {
  return {v.x, v.y, v.z};
}
template <class T>
Vec<T> operator+(const Vec<T>& a, const Vec<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
Vec<T> operator-(const Vec<T>& a, const Vec<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
Vec<T> operator*(const T& s, const Vec<T>& v) {
  return {s * v.x, s * v.y, s * v.z};
}
template <class T>
T dot(const Vec<T>& a, const Vec<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
Vec<T> cross(const Vec<T>& a, const Vec<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T length(const Vec<T>& v) {
  using std::sqrt;
  return sqrt(dot(v, v));
}
template <class T>
Vec<T> unit(const Vec<T>& v) {
  return (T(1) / length(v)) * v;
}

/// Midpoint of the shortest connection between two lines of sight, each from an eye to its dot.
template <class T>
Vec<T> closest_point(const Vec<T>& left, const Vec<T>& left_dot, const Vec<T>& right, const Vec<T>& right_dot) {
  const Vec<T> d = unit(left_dot - left), e = unit(right_dot - right), w = left - right;
  const T de = dot(d, e), dw = dot(d, w), ew = dot(e, w), det = T(1) - de * de;
  return T(0.5) * (left + ((de * ew - dw) / det) * d + right + ((ew - de * dw) / det) * e);
}

/// A panel. u, v: 0..1 along the edges `right` and `up`. The panel's height above the plane of its edges, in the
/// direction right × up: bow.x · 4u(1−u) + bow.y · 4v(1−v) + bow.z · uv.
template <class T>
struct Panel {
  Vec<T> corner, right, up, bow;
  T height(const T& u, const T& v) const {
    return bow.x * T(4) * u * (T(1) - u) + bow.y * T(4) * v * (T(1) - v) + bow.z * u * v;
  }
  Vec<T> at(const T& u, const T& v) const {
    return corner + u * right + v * up + height(u, v) * unit(cross(right, up));
  }
};

/// A mirror: points p with normal · (p − middle) = (c.x s² + 2 c.y s t + c.z t²)/2; s, t: coordinates of p − middle
/// along the unit vectors a and b; c: curvature, 1/m.
template <class T>
struct Mirror {
  Vec<T> normal, middle, a, b, curvature;

  /// The plane normal · p = offset, curved about the point of the plane nearest to `about`. a: the direction in the
  /// plane that is nearest to the axis x, or y, if x is nearly normal to the plane; b = normal × a.
  static Mirror make(const Vec<T>& normal, const T& offset, const Vec<T>& about, const Vec<T>& curvature) {
    using std::abs;
    const Vec<T> axis = abs(normal.x) < T(0.9) ? vec<T>({1, 0, 0}) : vec<T>({0, 1, 0});
    const Vec<T> a = unit(axis - dot(normal, axis) * normal);
    return {normal, about - (dot(normal, about) - offset) * normal, a, cross(normal, a), curvature};
  }
  /// Height of p above the mirror's surface, along `normal`.
  T height(const Vec<T>& p) const {
    const Vec<T> d = p - middle;
    return dot(normal, d) - sag(dot(a, d), dot(b, d));
  }
  T sag(const T& s, const T& t) const {
    return T(0.5) * (curvature.x * s * s + T(2) * curvature.y * s * t + curvature.z * t * t);
  }
  /// Derivatives of sag() by s and t.
  std::array<T, 2> slope(const T& s, const T& t) const {
    return {curvature.x * s + curvature.y * t, curvature.y * s + curvature.z * t};
  }
};

/// Position at which an eye sees the point p in the mirror: on the line of sight, as far from the eye as the light's
/// path is long. The path is the shortest one (Fermat); Newton's method finds it.
template <class T>
Vec<T> seen_in(const Mirror<T>& mirror, const Vec<T>& eye, const Vec<T>& p) {
  const T eye_above = dot(mirror.normal, eye - mirror.middle), p_above = dot(mirror.normal, p - mirror.middle);
  const Vec<T> image = p - T(2) * p_above * mirror.normal;
  const Vec<T> start = eye + (eye_above / (eye_above + p_above)) * (image - eye) - mirror.middle;
  T s = dot(mirror.a, start), t = dot(mirror.b, start);
  Vec<T> to_eye, to_p;
  for (int round = 0; round < 5; ++round) {
    const Vec<T> m = mirror.middle + s * mirror.a + t * mirror.b + mirror.sag(s, t) * mirror.normal;
    to_eye = m - eye, to_p = m - p;
    if (round == 4) break;
    const auto [by_s, by_t] = mirror.slope(s, t);
    const Vec<T> m_s = mirror.a + by_s * mirror.normal, m_t = mirror.b + by_t * mirror.normal;
    const T r = length(to_eye), q = length(to_p);
    const Vec<T> e = (T(1) / r) * to_eye, f = (T(1) / q) * to_p, sum = e + f;
    const auto second = [&](const Vec<T>& i, const Vec<T>& j, const T& curvature) {
      return (dot(i, j) - dot(e, i) * dot(e, j)) / r + (dot(i, j) - dot(f, i) * dot(f, j)) / q +
             dot(sum, mirror.normal) * curvature;
    };
    const T ss = second(m_s, m_s, mirror.curvature.x), st = second(m_s, m_t, mirror.curvature.y),
            tt = second(m_t, m_t, mirror.curvature.z), gs = dot(sum, m_s), gt = dot(sum, m_t), det = ss * tt - st * st;
    s = s - (tt * gs - st * gt) / det;
    t = t - (ss * gt - st * gs) / det;
  }
  return eye + (T(1) + length(to_p) / length(to_eye)) * to_eye;
}

/// The pixel (u, v) through which an eye sees the point p: where the line of sight from the eye to p, after the mirror,
/// meets the panel. `mirror`: null if there is none.
inline std::array<double, 2> pixel_through(const Panel<double>& panel, const Mirror<double>* mirror, const dvec3& p_eye,
                                           const dvec3& p) {
  Vec<double> from = vec<double>(p_eye), along = vec<double>(p - p_eye);
  constexpr int kRounds = 8;  // each round reduces the error by the slope of the surface, at least 20 times
  if (mirror) {
    const Vec<double> d = from - mirror->middle;
    const double down = -dot(mirror->normal, along);
    double s = 0, t = 0, far = 0;
    for (int round = 0; round < kRounds; ++round) {
      far = (dot(mirror->normal, d) - mirror->sag(s, t)) / down;
      const Vec<double> at = d + far * along;
      s = dot(mirror->a, at), t = dot(mirror->b, at);
    }
    const auto [by_s, by_t] = mirror->slope(s, t);
    const Vec<double> normal = unit(mirror->normal - by_s * mirror->a - by_t * mirror->b);
    from = from + far * along;
    along = along - 2 * dot(along, normal) * normal;
  }
  const Vec<double> normal = unit(cross(panel.right, panel.up)), d = from - panel.corner;
  const double uu = dot(panel.right, panel.right), uv = dot(panel.right, panel.up), vv = dot(panel.up, panel.up);
  double u = 0.5, v = 0.5;
  for (int round = 0; round < kRounds; ++round) {
    const Vec<double> hit = d - ((dot(normal, d) - panel.height(u, v)) / dot(normal, along)) * along;
    // The edges need not be perpendicular.
    const double hu = dot(hit, panel.right), hv = dot(hit, panel.up), det = uu * vv - uv * uv;
    u = (hu * vv - hv * uv) / det, v = (hv * uu - hu * uv) / det;
  }
  return {u, v};
}

}  // namespace typodont::sight
