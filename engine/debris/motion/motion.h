// The inner loop over particles, compiled for several instruction sets with the same results.
#pragma once

#include <cstddef>
#include <cstdint>

namespace typodont::debris {

/// Arrays of the same length; W, SI.
struct Motion {
  float *x, *y, *z;           // m
  float *vx, *vy, *vz;        // m/s
  const float* rate;          // 1/s, drag: dv/dt = −rate·(v − air)
  const std::uint32_t* due;   // step in which the particle needs more than this loop
};

/// Particles per block whose `due` is looked at together.
inline constexpr std::size_t kBlock = 256;

/// What acts on all particles alike.
struct Surroundings {
  float gravity[3];    // m/s²
  float sink[3];       // m, where air is drawn to …
  float strength = 0;  // m³/s/sr: … at strength/r²; 0: air at rest
};

/// Semi-implicit Euler for particles first … last−1: v ← (v + g·dt + rate·dt·air) / (1 + rate·dt), p ← p + v·dt. Writes
/// the numbers of those due at `step` to `found` and returns how many.
std::size_t move(const Motion& motion, std::size_t first, std::size_t last, float dt, const Surroundings& around,
                 std::uint32_t step, std::uint32_t* found) noexcept;

/// Drag rate of a ball of diameter d moving at speed v through air: Stokes' 18 μ/(ρ d²) times Schiller & Naumann's
/// 1 + 0.15 Re^0.687 (Re < 1000; beyond, drag coefficient 0.44).
double drag_rate(double speed, double diameter, double density, double air_density, double air_viscosity) noexcept;

}  // namespace typodont::debris
