#include "engine/debris/motion/motion.h"

#include <algorithm>
#include <cmath>

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

TYPODONT_VERSIONS
void draw_block(const float* __restrict x, const float* __restrict y, const float* __restrict z, float* __restrict vx,
                float* __restrict vy, float* __restrict vz, const float* __restrict keep, std::size_t count, float sx,
                float sy, float sz, float strength) {
  for (std::size_t i = 0; i < count; ++i) {
    const float dx = sx - x[i], dy = sy - y[i], dz = sz - z[i];
    const float r2 = dx * dx + dy * dy + dz * dz + 1e-12f;
    // Before move_block multiplies by keep. What is at rest (keep 0) is not drawn.
    const float pull = keep[i] > 0 ? (1 - keep[i]) / keep[i] * strength / (r2 * std::sqrt(r2)) : 0.0f;
    vx[i] += pull * dx;
    vy[i] += pull * dy;
    vz[i] += pull * dz;
  }
}

TYPODONT_VERSIONS
void copy_block(float* __restrict x, float* __restrict y, float* __restrict z, float* __restrict vx,
                float* __restrict vy, float* __restrict vz, const float* __restrict keep, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    vx[i] += keep[i];
    vy[i] += keep[i];
    vz[i] += keep[i];
    x[i] += vx[i];
    y[i] += vy[i];
    z[i] += vz[i];
  }
}

// C_d = 24/Re (1 + 0.15 Re^0.687), Re < 1000 (Schiller & Naumann 1933), over Stokes' 24/Re.
double schiller_naumann(double reynolds) {
  return 1 + 0.15 * std::pow(reynolds, 0.687);
}

// Straight lines between points even in each octave.
struct DragTable {
  static constexpr int kLow = -8, kHigh = 10, kPerOctave = 32;  // Re = 2^kLow … 2^kHigh
  double value[(kHigh - kLow) * kPerOctave + 1];

  DragTable() {
    for (int i = 0; i <= (kHigh - kLow) * kPerOctave; ++i) {
      const double mantissa = 1 + static_cast<double>(i % kPerOctave) / kPerOctave;
      value[i] = schiller_naumann(std::ldexp(mantissa, kLow + i / kPerOctave));
    }
  }
};

}  // namespace

void copy_through(const Motion& m, std::size_t count) noexcept {
  copy_block(m.x, m.y, m.z, m.vx, m.vy, m.vz, m.keep, count);
}

void move(const Motion& m, std::size_t first, std::size_t last, float dt, const Surroundings& around) noexcept {
  constexpr std::size_t kBlock = 1024;  // stays in the first cache from one loop to the next
  for (std::size_t i = first; i < last; i += kBlock) {
    const std::size_t n = std::min(kBlock, last - i);
    if (around.strength != 0) {
      draw_block(m.x + i, m.y + i, m.z + i, m.vx + i, m.vy + i, m.vz + i, m.keep + i, n, around.sink[0], around.sink[1],
                 around.sink[2], around.strength);
    }
    move_block(m.x + i, m.y + i, m.z + i, m.vx + i, m.vy + i, m.vz + i, m.keep + i, n, dt, around.gravity[0] * dt,
               around.gravity[1] * dt, around.gravity[2] * dt);
  }
}

TYPODONT_VERSIONS
void set_keep(const float* __restrict rate, float* __restrict keep, std::size_t count, float dt) noexcept {
  for (std::size_t i = 0; i < count; ++i) keep[i] = 1.0f / (1.0f + rate[i] * dt);
}

double drag_factor(double reynolds) noexcept {
  static const DragTable table;
  if (reynolds < std::ldexp(1.0, DragTable::kLow) || reynolds >= 1000) {
    return reynolds < 1000 ? schiller_naumann(reynolds) : 0.44 * reynolds / 24;
  }
  int exponent = 0;
  const double mantissa = 2 * std::frexp(reynolds, &exponent) - 1;  // 0..1
  const double at = (exponent - 1 - DragTable::kLow + mantissa) * DragTable::kPerOctave;
  const int i = static_cast<int>(at);
  return table.value[i] + (at - i) * (table.value[i + 1] - table.value[i]);
}

double drag_rate(double speed, double diameter, double density, double air_density, double air_viscosity) noexcept {
  const double stokes = 18 * air_viscosity / (density * diameter * diameter);
  const double reynolds = air_density * speed * diameter / air_viscosity;
  return stokes * drag_factor(reynolds);
}

}  // namespace typodont::debris
