#include "engine/debris/motion/motion.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "engine/base/dispatch.h"

namespace typodont::debris {
namespace {

#define TYPODONT_VERSIONS TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")

TYPODONT_VERSIONS
void move_block(float* __restrict x, float* __restrict y, float* __restrict z, float* __restrict vx,
                float* __restrict vy, float* __restrict vz, const float* __restrict keep, std::size_t count, float dt,
                float gx, float gy, float gz) {
  for (std::size_t i = 0; i < count; ++i) {
    vx[i] = (vx[i] + gx) * keep[i];
    vy[i] = (vy[i] + gy) * keep[i];
    vz[i] = (vz[i] + gz) * keep[i];
    x[i] += vx[i] * dt;
    y[i] += vy[i] * dt;
    z[i] += vz[i] * dt;
  }
}

/// Returns 1/√a with a relative error below 2e-3. An exact root would need most of the loop's time. Uses Lomont's
/// initial value (2003) and one Newton step.
inline float reciprocal_root(float a) {
  const float guess = std::bit_cast<float>(0x5f375a86u - (std::bit_cast<std::uint32_t>(a) >> 1));
  return guess * (1.5f - 0.5f * a * guess * guess);
}

/// Mean speed of air that flows to the nozzle in a step, divided by its distance from the nozzle, 1/s. pull: this ratio
/// at the start of the step; q = pull·dt. Exact: (1 − ∛(1 − 3q))/dt. Here: pull·(1 + 2q); 1/dt if q ≥ 1/3.
inline float mean_approach_rate(float pull, float dt) {
  return pull * dt < 1.0f / 3 ? pull * (1 + 2 * dt * pull) : 1 / dt;
}

/// Moves particles as move_block() does, but with suction.
TYPODONT_VERSIONS
void draw_block(float* __restrict x, float* __restrict y, float* __restrict z, float* __restrict vx,
                float* __restrict vy, float* __restrict vz, const float* __restrict keep, std::size_t count, float dt,
                float gx, float gy, float gz, float sx, float sy, float sz, float strength) {
  for (std::size_t i = 0; i < count; ++i) {
    const float dx = sx - x[i], dy = sy - y[i], dz = sz - z[i];
    const float near = reciprocal_root(dx * dx + dy * dy + dz * dz + 1e-12f);
    // Suction does not move a particle at rest (keep = 0).
    const float air = (keep[i] > 0 ? 1 - keep[i] : 0.0f) * mean_approach_rate(strength * near * near * near, dt);
    vx[i] = (vx[i] + gx) * keep[i] + air * dx;
    vy[i] = (vy[i] + gy) * keep[i] + air * dy;
    vz[i] = (vz[i] + gz) * keep[i] + air * dz;
    x[i] += vx[i] * dt;
    y[i] += vy[i] * dt;
    z[i] += vz[i] * dt;
  }
}

// Returns the drag coefficient divided by that of Stokes drag, 24/Re, for Re < 1000 (Schiller & Naumann 1933).
double schiller_naumann(double reynolds) {
  return 1 + 0.15 * std::pow(reynolds, 0.687);
}

// Table of schiller_naumann(). Its points are evenly spaced in each octave of Re, and values between
// points are interpolated linearly.
struct DragTable {
  static constexpr int kLow = -8, kHigh = 10, kPerOctave = 32;  // the table contains Re from 2^kLow to 2^kHigh
  double value[(kHigh - kLow) * kPerOctave + 1];

  DragTable() {
    for (int i = 0; i <= (kHigh - kLow) * kPerOctave; ++i) {
      const double mantissa = 1 + static_cast<double>(i % kPerOctave) / kPerOctave;
      value[i] = schiller_naumann(std::ldexp(mantissa, kLow + i / kPerOctave));
    }
  }
};

}  // namespace

void move(const Motion& m, std::size_t first, std::size_t last, float dt, const Surroundings& around) noexcept {
  const std::size_t i = first, n = last - first;
  const float gx = around.gravity[0] * dt, gy = around.gravity[1] * dt, gz = around.gravity[2] * dt;
  if (around.strength != 0)
    draw_block(m.x + i, m.y + i, m.z + i, m.vx + i, m.vy + i, m.vz + i, m.keep + i, n, dt, gx, gy, gz, around.sink[0],
               around.sink[1], around.sink[2], around.strength);
  else
    move_block(m.x + i, m.y + i, m.z + i, m.vx + i, m.vy + i, m.vz + i, m.keep + i, n, dt, gx, gy, gz);
}

TYPODONT_VERSIONS
void set_keep(const float* __restrict rate, float* __restrict keep, std::size_t count, float dt) noexcept {
  for (std::size_t i = 0; i < count; ++i) keep[i] = 1.0f / (1.0f + rate[i] * dt);
}

double mean_air_speed(double strength, double distance, double dt) noexcept {
  return mean_approach_rate(static_cast<float>(strength / (distance * distance * distance)), static_cast<float>(dt)) *
         distance;
}

double drag_factor(double reynolds) noexcept {
  static const DragTable table;
  constexpr double kMin = 1.0 / (1 << -DragTable::kLow);
  if (reynolds < kMin || reynolds >= 1000) {
    return reynolds < 1000 ? schiller_naumann(reynolds) : 0.44 * reynolds / 24;
  }
  // Reads the exponent and the mantissa of the Reynolds number from its bits.
  const auto bits = std::bit_cast<std::uint64_t>(reynolds);
  const int exponent = static_cast<int>(bits >> 52) - 1023;
  // the mantissa of the number minus one, 0..1
  const double mantissa = std::bit_cast<double>((bits & ((1ull << 52) - 1)) | 1023ull << 52) - 1;
  const double at = (exponent - DragTable::kLow + mantissa) * DragTable::kPerOctave;
  const int i = static_cast<int>(at);
  return table.value[i] + (at - i) * (table.value[i + 1] - table.value[i]);
}

double drag_rate(double speed, double diameter, double density, double air_density, double air_viscosity) noexcept {
  const double stokes = 18 * air_viscosity / (density * diameter * diameter);
  const double reynolds = air_density * speed * diameter / air_viscosity;
  return stokes * drag_factor(reynolds);
}

}  // namespace typodont::debris
