#include "audio/ar/levinson.h"

#include <cmath>
#include <complex>

#include "audio/ar/spectrum.h"
#include "engine/base/units.h"

namespace typodont::audio {

std::vector<double> step_up(const std::vector<double>& reflection) {
  std::vector<double> a;
  for (const double k : reflection) {
    const std::size_t m = a.size();
    std::vector<double> next(a);
    for (std::size_t i = 0; i < m; ++i) next[i] += k * a[m - 1 - i];
    next.push_back(k);
    a = std::move(next);
  }
  return a;
}

std::vector<double> step_down(std::vector<double> a) {
  std::vector<double> reflection(a.size(), 0.0);
  while (!a.empty()) {
    const std::size_t m = a.size() - 1;
    const double k = a[m];
    reflection[m] = k;
    if (!(std::abs(k) < 1)) break;
    std::vector<double> lower(m);
    for (std::size_t i = 0; i < m; ++i) lower[i] = (a[i] - k * a[m - 1 - i]) / (1 - k * k);
    a = std::move(lower);
  }
  return reflection;
}

std::vector<double> reflection_of_autocorrelation(const std::vector<double>& r) {
  std::vector<double> reflection, a;
  double error = r.at(0);
  for (std::size_t m = 1; m < r.size(); ++m) {
    double sum = r[m];
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * r[m - 1 - i];
    const double k = error > 0 ? -sum / error : 0.0;
    std::vector<double> next(a);
    for (std::size_t i = 0; i < a.size(); ++i) next[i] += k * a[a.size() - 1 - i];
    next.push_back(k);
    a = std::move(next);
    reflection.push_back(k);
    error *= 1 - k * k;
  }
  return reflection;
}

double predictor_power(const std::vector<double>& reflection, double angle) {
  const std::complex<double> z = std::polar(1.0, -angle);
  std::complex<double> forward = 1, backward = 1;
  for (const double k : reflection) {
    const std::complex<double> delayed = z * backward;
    backward = k * forward + delayed;
    forward += k * delayed;
  }
  return std::norm(forward);
}

std::vector<double> sampled_power(const std::vector<double>& reflection, double gain, std::size_t count) {
  std::vector<double> power(count);
  for (std::size_t i = 0; i < count; ++i)
    power[i] = gain * gain / predictor_power(reflection, kPi * static_cast<double>(i) / static_cast<double>(count - 1));
  return power;
}

std::vector<double> reflection_of_power(const std::vector<double>& power, std::size_t order, double& gain) {
  std::vector<double> r = autocorrelation_of_power(power);
  r.resize(order + 1);
  auto reflection = reflection_of_autocorrelation(r);
  double variance = r[0];
  for (const double k : reflection) variance *= 1 - k * k;
  gain = std::sqrt(variance);
  return reflection;
}

}  // namespace typodont::audio
