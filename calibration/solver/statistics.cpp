#include "calibration/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace typodont::calibration {

namespace {

// Regularised incomplete gamma function, by series or continued fraction (Abramowitz & Stegun 6.5.29, 6.5.31).
double gamma_p(double a, double x) {
  if (x <= 0) return 0;
  const double scale = std::exp(-x + a * std::log(x) - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (int n = 1; n < 10'000 && term > sum * 1e-17; ++n) sum += (term *= x / (a + n));
    return sum * scale;
  }
  double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
  for (int n = 1; n < 10'000; ++n) {
    const double an = -n * (n - a);
    b += 2;
    d = 1 / (an * d + b);
    c = b + an / c;
    h *= d * c;
    if (std::abs(d * c - 1) < 1e-16) break;
  }
  return 1 - scale * h;
}

// Incomplete beta function as a continued fraction (Abramowitz & Stegun 26.5.8), by Lentz's method.
double beta_fraction(double a, double b, double x) {
  const double tiny = 1e-300;
  double c = 1, d = 1 - (a + b) * x / (a + 1);
  d = 1 / (std::abs(d) < tiny ? tiny : d);
  double h = d;
  for (int m = 1; m < 10'000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 + even * d, c = 1 + even / c;
    d = 1 / (std::abs(d) < tiny ? tiny : d), c = std::abs(c) < tiny ? tiny : c;
    h *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 + odd * d, c = 1 + odd / c;
    d = 1 / (std::abs(d) < tiny ? tiny : d), c = std::abs(c) < tiny ? tiny : c;
    h *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return h;
}

// 1 - I_x(a, b), where I_x is the regularised incomplete beta function; accurate also if the result is tiny.
double beta_upper(double a, double b, double x) {
  if (x <= 0) return 1;
  if (x >= 1) return 0;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  if (x < (a + 1) / (a + b + 2)) return 1 - front * beta_fraction(a, b, x) / a;
  return front * beta_fraction(b, a, 1 - x) / b;
}

// Zero of an increasing function: bisection of the logarithm, then the Illinois method.
template <class F>
double solve_increasing(F f) {
  double low = 1e-12, high = 1e12;
  while (high > 2 * low) {
    const double mid = std::sqrt(low * high);
    (f(mid) < 0 ? low : high) = mid;
  }
  double f_low = f(low), f_high = f(high);
  for (int i = 0, side = 0; i < 60 && high - low > 1e-15 * high && f_high > f_low; ++i) {
    const double mid = std::clamp((low * f_high - high * f_low) / (f_high - f_low), low, high), f_mid = f(mid);
    if (f_mid == 0) return mid;
    if (f_mid < 0) {
      low = mid, f_low = f_mid;
      if (side == -1) f_high *= 0.5;
      side = -1;
    } else {
      high = mid, f_high = f_mid;
      if (side == 1) f_low *= 0.5;
      side = 1;
    }
  }
  return 0.5 * (low + high);
}

}  // namespace

double chi_squared_cdf(double x, double dof) {
  return gamma_p(dof / 2, x / 2);
}

double chi_squared_quantile(double p, double dof) {
  return solve_increasing([&](double x) { return chi_squared_cdf(x, dof) - p; });
}

double f_quantile(double p, double d1, double d2) {
  return solve_increasing([&](double f) { return (1 - p) - beta_upper(d1 / 2, d2 / 2, d1 * f / (d1 * f + d2)); });
}

dvec3 Noise::normal3(double sigma) {
  const double x = normal(sigma), y = normal(sigma), z = normal(sigma);
  return {x, y, z};
}

dvec3 Noise::in_box(const dvec3& low, const dvec3& high) {
  const double x = uniform(low.x, high.x), y = uniform(low.y, high.y), z = uniform(low.z, high.z);
  return {x, y, z};
}

dquat Noise::rotation() {
  const double w = normal(), x = normal(), y = normal(), z = normal();
  return glm::normalize(dquat(w, x, y, z));
}

}  // namespace typodont::calibration
