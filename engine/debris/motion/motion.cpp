#include "engine/debris/motion/motion.h"

#include <algorithm>
#include <cmath>

namespace typodont::debris {
namespace {

// No multiply-adds are contracted (-ffp-contract=off), so all versions give the same bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define TYPODONT_VERSIONS __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define TYPODONT_VERSIONS
#endif

TYPODONT_VERSIONS
unsigned move_block(float* __restrict x, float* __restrict y, float* __restrict z, float* __restrict vx,
                    float* __restrict vy, float* __restrict vz, const float* __restrict rate,
                    const std::uint32_t* __restrict due, std::size_t count, float dt, float gx, float gy, float gz,
                    std::uint32_t step) {
  unsigned any = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const float keep = 1.0f / (1.0f + rate[i] * dt);
    vx[i] = (vx[i] + gx) * keep;
    vy[i] = (vy[i] + gy) * keep;
    vz[i] = (vz[i] + gz) * keep;
    x[i] += vx[i] * dt;
    y[i] += vy[i] * dt;
    z[i] += vz[i] * dt;
    any |= due[i] <= step;
  }
  return any;
}

TYPODONT_VERSIONS
void draw_block(const float* __restrict x, const float* __restrict y, const float* __restrict z, float* __restrict vx,
                float* __restrict vy, float* __restrict vz, const float* __restrict rate, std::size_t count, float dt,
                float sx, float sy, float sz, float strength) {
  for (std::size_t i = 0; i < count; ++i) {
    const float dx = sx - x[i], dy = sy - y[i], dz = sz - z[i];
    const float r2 = dx * dx + dy * dy + dz * dz + 1e-12f;
    // Added before the division by 1 + rate·dt. At rest (rate infinite) nothing is drawn.
    const float pull = rate[i] < 1e12f ? rate[i] * dt * strength / (r2 * std::sqrt(r2)) : 0.0f;
    vx[i] += pull * dx;
    vy[i] += pull * dy;
    vz[i] += pull * dz;
  }
}

}  // namespace

std::size_t move(const Motion& m, std::size_t first, std::size_t last, float dt, const Surroundings& around,
                 std::uint32_t step, std::uint32_t* found) noexcept {
  std::size_t count = 0;
  for (std::size_t i = first; i < last; i += kBlock) {
    const std::size_t n = std::min(kBlock, last - i);
    if (around.strength != 0) {
      draw_block(m.x + i, m.y + i, m.z + i, m.vx + i, m.vy + i, m.vz + i, m.rate + i, n, dt, around.sink[0],
                 around.sink[1], around.sink[2], around.strength);
    }
    if (!move_block(m.x + i, m.y + i, m.z + i, m.vx + i, m.vy + i, m.vz + i, m.rate + i, m.due + i, n, dt,
                    around.gravity[0] * dt, around.gravity[1] * dt, around.gravity[2] * dt, step)) {
      continue;
    }
    for (std::size_t k = i; k < i + n; ++k) {
      if (m.due[k] <= step) found[count++] = static_cast<std::uint32_t>(k);
    }
  }
  return count;
}

double drag_rate(double speed, double diameter, double density, double air_density, double air_viscosity) noexcept {
  const double stokes = 18 * air_viscosity / (density * diameter * diameter);
  const double reynolds = air_density * speed * diameter / air_viscosity;
  // C_d = 24/Re (1 + 0.15 Re^0.687) below Re = 1000, 0.44 above (Schiller & Naumann 1933).
  const double factor = reynolds < 1000 ? 1 + 0.15 * std::pow(reynolds, 0.687) : 0.44 * reynolds / 24;
  return stokes * factor;
}

}  // namespace typodont::debris
