// The inner loop over particles, compiled for several instruction sets with equal results.
#pragma once

#include <cstddef>
#include <cstdint>

namespace typodont::debris {

/// Positions and velocities of particles, as arrays of equal length.
struct Motion {
  float *x, *y, *z;     // m, frame W, positions of the particles
  float *vx, *vy, *vz;  // m/s, frame W, velocities of the particles
  // factor per step of the velocity relative to the air, 1/(1 + rate·dt); 0: the particle is at rest
  const float* keep;
};

/// Gravity and air flow that act on all particles.
struct Surroundings {
  float gravity[3];  // m/s², frame W, acceleration of gravity
  float sink[3];     // m, frame W, position of the suction nozzle
  // m³/s per steradian; air at the distance r flows to the nozzle at strength/r². 0: no suction.
  float strength = 0;
};

/// Moves the particles first … last−1 by one semi-implicit step: v ← keep·(v + g·dt) + (1 − keep)·air, p ← p + v·dt.
void move(const Motion& motion, std::size_t first, std::size_t last, float dt, const Surroundings& around) noexcept;

/// Returns the mean speed (m/s) of the air that starts a step at `distance` (m) from the nozzle.
double mean_air_speed(double strength, double distance, double dt) noexcept;

/// Sets keep = 1/(1 + rate·dt) for each particle.
void set_keep(const float* rate, float* keep, std::size_t count, float dt) noexcept;

/// Returns 1 + 0.15 Re^0.687 (Schiller & Naumann), from a table with a relative error below 1e-4.
double drag_factor(double reynolds) noexcept;

/// Returns the drag rate (1/s) of a ball of diameter d and density ρ: 18 μ/(ρ d²) × (1 + 0.15 Re^0.687) for Re < 1000
/// (Schiller & Naumann), and C_d = 0.44 above.
double drag_rate(double speed, double diameter, double density, double air_density, double air_viscosity) noexcept;

}  // namespace typodont::debris
