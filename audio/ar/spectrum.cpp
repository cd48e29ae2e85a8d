#include "audio/ar/spectrum.h"

#include <fftw3.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <numeric>

#include "engine/base/units.h"

namespace typodont::audio {

namespace {

struct FftwFree {
  void operator()(void* p) const { fftw_free(p); }
};
/// Mutex for the planner of FFTW, which is not thread-safe.
std::mutex& planner() {
  static std::mutex one;
  return one;
}
struct PlanFree {
  void operator()(fftw_plan_s* p) const {
    const std::lock_guard lock(planner());
    fftw_destroy_plan(p);
  }
};

/// Fourier transform of real samples of a fixed length, forward and inverse.
class RealFft {
 public:
  explicit RealFft(std::size_t n)
      : n_(n), time_(fftw_alloc_real(n)), frequency_(reinterpret_cast<double*>(fftw_alloc_complex(n / 2 + 1))) {
    const std::lock_guard lock(planner());
    forward_.reset(fftw_plan_dft_r2c_1d(static_cast<int>(n), time_.get(), bins(), FFTW_ESTIMATE));
    backward_.reset(fftw_plan_dft_c2r_1d(static_cast<int>(n), bins(), time_.get(), FFTW_ESTIMATE));
  }

  std::span<double> time() { return {time_.get(), n_}; }
  double& re(std::size_t i) { return frequency_.get()[2 * i]; }
  double& im(std::size_t i) { return frequency_.get()[2 * i + 1]; }
  double power(std::size_t i) { return re(i) * re(i) + im(i) * im(i); }
  void forward() { fftw_execute(forward_.get()); }
  void backward() { fftw_execute(backward_.get()); }  // the result is not divided by the length

 private:
  fftw_complex* bins() { return reinterpret_cast<fftw_complex*>(frequency_.get()); }
  std::size_t n_;
  std::unique_ptr<double, FftwFree> time_;
  std::unique_ptr<double, FftwFree> frequency_;
  std::unique_ptr<fftw_plan_s, PlanFree> forward_, backward_;
};

}  // namespace

std::vector<double> window_samples(Window window, std::size_t n) {
  std::vector<double> w(n, 1.0);
  for (std::size_t i = 0; i < n && window != Window::kNone; ++i) {
    const double turn = 2 * kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    if (window == Window::kHann) w[i] = 0.5 - 0.5 * std::cos(turn);
    if (window == Window::kHamming) w[i] = 0.54 - 0.46 * std::cos(turn);
    if (window == Window::kBlackman) w[i] = 0.42 - 0.5 * std::cos(turn) + 0.08 * std::cos(2 * turn);
  }
  return w;
}

std::vector<double> welch(std::span<const double> x, std::size_t n, double rate) {
  RealFft fft(n);
  const auto w = window_samples(Window::kHann, n);
  double weight = 0;
  for (const double v : w) weight += v * v;
  std::vector<double> power(n / 2 + 1, 0.0);
  std::size_t segments = 0;
  for (std::size_t at = 0; at == 0 || at + n <= x.size(); at += std::max<std::size_t>(1, n / 2)) {
    for (std::size_t i = 0; i < n; ++i) fft.time()[i] = at + i < x.size() ? w[i] * x[at + i] : 0.0;
    fft.forward();
    for (std::size_t i = 0; i < power.size(); ++i) power[i] += fft.power(i);
    ++segments;
  }
  for (std::size_t i = 0; i < power.size(); ++i) {
    // In a one-sided spectrum, frequencies 0 and rate/2 count once, all others twice.
    const bool single = i == 0 || 2 * i == n;
    power[i] *= (single ? 1.0 : 2.0) / (rate * weight * static_cast<double>(segments));
  }
  return power;
}

std::vector<double> autocorrelation(std::span<const double> x, std::size_t lags) {
  std::size_t n = 2;
  while (n < x.size() + lags + 1) n *= 2;
  RealFft fft(n);
  std::fill(fft.time().begin(), fft.time().end(), 0.0);
  std::copy(x.begin(), x.end(), fft.time().begin());
  fft.forward();
  for (std::size_t i = 0; i <= n / 2; ++i) {
    fft.re(i) = fft.power(i);
    fft.im(i) = 0;
  }
  fft.backward();
  std::vector<double> r(lags + 1);
  const double scale = 1.0 / (static_cast<double>(n) * static_cast<double>(x.size()));
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = fft.time()[i] * scale;
  return r;
}

std::vector<double> autocorrelation_of_power(const std::vector<double>& power) {
  const std::size_t n = 2 * (power.size() - 1);
  RealFft fft(n);
  for (std::size_t i = 0; i < power.size(); ++i) {
    fft.re(i) = power[i];
    fft.im(i) = 0;
  }
  fft.backward();
  std::vector<double> r(power.size());
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = fft.time()[i] / static_cast<double>(n);
  return r;
}

std::vector<double> power_of_taps(std::span<const double> taps, std::size_t points) {
  RealFft fft(2 * (points - 1));
  std::fill(fft.time().begin(), fft.time().end(), 0.0);
  fft.time()[0] = 1;
  std::copy(taps.begin(), taps.end(), fft.time().begin() + 1);
  fft.forward();
  std::vector<double> power(points);
  for (std::size_t i = 0; i < points; ++i) power[i] = fft.power(i);
  return power;
}

std::vector<double> expected_welch(const std::vector<double>& power, std::size_t n, double rate) {
  // Fourier transform of the signal's autocorrelation × the window's autocorrelation (Blackman & Tukey 1958).
  const auto r = autocorrelation_of_power(power);
  const auto through = autocorrelation(window_samples(Window::kHann, n), n - 1);
  RealFft fft(2 * n);
  std::fill(fft.time().begin(), fft.time().end(), 0.0);
  for (std::size_t lag = 0; lag < n && lag < r.size(); ++lag) {
    const double v = r[lag] * through[lag] / through[0];
    fft.time()[lag] = v;
    if (lag > 0) fft.time()[2 * n - lag] = v;
  }
  fft.forward();
  std::vector<double> density(n / 2 + 1);
  for (std::size_t i = 0; i < density.size(); ++i) {
    density[i] = std::max(0.0, fft.re(2 * i)) * (i == 0 || 2 * i == n ? 1.0 : 2.0) / rate;
  }
  return density;
}

double mean_power(std::span<const double> x) {
  return x.empty() ? 0.0 : std::inner_product(x.begin(), x.end(), x.begin(), 0.0) / static_cast<double>(x.size());
}

double in_dB(double power) {
  return 10 * std::log10(power + 1e-30);
}

std::vector<double> frame_levels(std::span<const double> x, std::size_t frame) {
  std::vector<double> levels;
  for (std::size_t at = 0; at + frame <= x.size(); at += frame)
    levels.push_back(in_dB(mean_power(x.subspan(at, frame))));
  return levels;
}

double log_spectral_distance(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = 10 * std::log10((a[i] + 1e-30) / (b[i] + 1e-30));
    sum += d * d;
  }
  return a.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(a.size()));
}

double chance_distance(std::size_t count, std::size_t n) {
  const double windows = count < n ? 1 : 1 + std::floor(2 * static_cast<double>(count - n) / static_cast<double>(n));
  // The powers in two Hann windows that overlap by half have a correlation of 1/36.
  const double variance = (1 + 2.0 / 36 * (windows - 1) / windows) / windows;
  return 10 / std::log(10.0) * std::sqrt(variance);
}

double itakura_saito(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double ratio = (a[i] + 1e-30) / (b[i] + 1e-30);
    sum += ratio - std::log(ratio) - 1;
  }
  return a.empty() ? 0.0 : sum / static_cast<double>(a.size());
}

}  // namespace typodont::audio
