// The inner loop over particles, compiled for several instruction sets with equal results.
#pragma once

#include <cstddef>
#include <cstdint>

namespace typodont::debris {

/// Arrays of equal length, W, SI.
struct Motion {
  float *x, *y, *z;     // m, frame W, positions of the particles
  float *vx, *vy, *vz;  // m/s, frame W, velocities of the particles
  // 1/(1 + rate·dt), of the velocity relative to the air; 0 at rest
  const float* keep;
};

/// Gravity and air flow that act on all particles.
struct Surroundings {
  float gravity[3];  // m/s², frame W, acceleration of gravity
  float sink[3];     // m, frame W, position of the suction nozzle
  // m³/s/sr; air moves at strength/r² to the nozzle; 0: off
  float strength = 0;
};

/// Particles first … last−1, semi-implicit: v ← keep·(v + g·dt) + (1 − keep)·air, p ← p + v·dt.
void move(const Motion& motion, std::size_t first, std::size_t last, float dt, const Surroundings& around) noexcept;

/// m/s at `distance` (m) during a step.
double mean_air_speed(double strength, double distance, double dt) noexcept;

/// keep = 1/(1 + rate·dt).
void set_keep(const float* rate, float* keep, std::size_t count, float dt) noexcept;

/// 1 + 0.15 Re^0.687 (Schiller & Naumann), from a table within 1e-4.
double drag_factor(double reynolds) noexcept;

/// 1/s, ball of diameter d and density ρ: 18 μ/(ρ d²) × (1 + 0.15 Re^0.687) below Re 1000 (Schiller & Naumann), C_d =
/// 0.44 above.
double drag_rate(double speed, double diameter, double density, double air_density, double air_viscosity) noexcept;

}  // namespace typodont::debris
