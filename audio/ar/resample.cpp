#include "audio/ar/resample.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "audio/ar/simd.h"
#include "engine/base/units.h"

namespace typodont::audio {

namespace {

double bessel_i0(double x) {
  double sum = 1, term = 1;
  for (int i = 1; i < 60 && term > 1e-17 * sum; ++i) {
    term *= (x / (2 * i)) * (x / (2 * i));
    sum += term;
  }
  return sum;
}

/// Sinc × Kaiser window at t samples; 0 if |t| > `half`. `cutoff`: frequency / half the sampling rate.
double windowed_sinc(double t, double cutoff, double half, double beta) {
  if (std::abs(t) >= half) return 0;
  const double u = t / half;
  const double window = bessel_i0(beta * std::sqrt(1 - u * u)) / bessel_i0(beta);
  const double v = kPi * cutoff * t;
  return cutoff * window * (std::abs(v) < 1e-9 ? 1.0 : std::sin(v) / v);
}

TYPODONT_CLONES float dot_between(const float* row, const float* next_row, float blend, const float* x, int taps) {
  Float16 here{}, there{};
  for (int i = 0; i < taps; i += 16) {
    const Float16 sample = *reinterpret_cast<const Float16Unaligned*>(x + i);
    here += sample * *reinterpret_cast<const Float16Unaligned*>(row + i);
    there += sample * *reinterpret_cast<const Float16Unaligned*>(next_row + i);
  }
  here += blend * (there - here);
  float lanes[16];
  std::memcpy(lanes, &here, sizeof lanes);
  for (int width = 8; width > 0; width /= 2) {
    for (int i = 0; i < width; ++i) lanes[i] += lanes[i + width];
  }
  return lanes[0];
}

}  // namespace

std::vector<double> resampled(std::span<const double> x, double from_rate, double to_rate) {
  if (from_rate == to_rate) return {x.begin(), x.end()};
  constexpr double kCrossings = 64, kBeta = 12;
  // The transition band is about 0.06 r wide and ends at r/2, where r is the lower of the two sampling rates.
  const double cutoff = std::min(1.0, to_rate / from_rate) * 0.97;
  const double half = kCrossings / cutoff;
  const double step = from_rate / to_rate;
  const auto count = static_cast<std::size_t>(std::floor(static_cast<double>(x.size()) / step));
  // Table entries per sample. Cubic interpolation between entries allows any ratio of the two rates.
  constexpr double kTable = 1024;
  std::vector<double> table(static_cast<std::size_t>(half * kTable) + 4);
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = windowed_sinc(static_cast<double>(i) / kTable, cutoff, half, kBeta);
  }
  std::vector<double> y(count);
  for (std::size_t n = 0; n < count; ++n) {
    const double place = static_cast<double>(n) * step;
    const auto first = static_cast<std::ptrdiff_t>(std::max(0.0, std::ceil(place - half)));
    const auto last = std::min(static_cast<std::ptrdiff_t>(x.size()) - 1, static_cast<std::ptrdiff_t>(place + half));
    double sum = 0;
    for (std::ptrdiff_t i = first; i <= last; ++i) {
      const double t = std::abs(static_cast<double>(i) - place) * kTable;
      const auto at = std::min(static_cast<std::size_t>(t), table.size() - 3);
      const double f = t - static_cast<double>(at);
      const double before = table[at == 0 ? 1 : at - 1], a = table[at], b = table[at + 1], after = table[at + 2];
      const double value =
          a + 0.5 * f * (b - before + f * (2 * before - 5 * a + 4 * b - after + f * (3 * (a - b) + after - before)));
      sum += value * x[static_cast<std::size_t>(i)];
    }
    y[n] = sum;
  }
  return y;
}

InterpolationKernels::InterpolationKernels(double fastest) {
  constexpr double kBeta = 8;
  for (double speed = 1;; speed *= std::sqrt(2.0)) {
    Set set;
    set.speed = speed * (1 + 1e-9);
    set.taps = static_cast<int>(std::ceil(32 * speed / 16)) * 16;
    const double half = set.taps / 2.0, cutoff = 1 / speed;
    set.rows.resize(static_cast<std::size_t>(kPhases + 1) * static_cast<std::size_t>(set.taps));
    for (int phase = 0; phase <= kPhases; ++phase) {
      for (int i = 0; i < set.taps; ++i) {
        // Tap i multiplies the sample x[i − taps/2 + 1]. With cut-off 1 and offset 0, the result equals the sample *x.
        const double t = i - (set.taps / 2 - 1) - static_cast<double>(phase) / kPhases;
        set.rows[static_cast<std::size_t>(phase) * static_cast<std::size_t>(set.taps) + static_cast<std::size_t>(i)] =
            static_cast<float>(windowed_sinc(t, cutoff, half, kBeta));
      }
    }
    sets_.push_back(std::move(set));
    if (sets_.back().speed >= fastest) break;
  }
}

const InterpolationKernels::Set& InterpolationKernels::set_for(double speed) const noexcept {
  for (const Set& set : sets_) {
    if (speed <= set.speed) return set;
  }
  return sets_.back();
}

int InterpolationKernels::reach(double speed) const noexcept {
  return set_for(speed).taps / 2;
}

float InterpolationKernels::read(const float* x, double offset, double speed) const noexcept {
  const Set& set = set_for(speed);
  const double phase = offset * kPhases;
  const int row = static_cast<int>(phase);
  const float* const rows = set.rows.data() + static_cast<std::ptrdiff_t>(row) * set.taps;
  return dot_between(rows, rows + set.taps, static_cast<float>(phase - row), x - set.taps / 2 + 1, set.taps);
}

}  // namespace typodont::audio
