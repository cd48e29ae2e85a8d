// The inner loop over the particles. It is compiled for several instruction sets, and all versions give the same
// results.
#pragma once

#include <cstddef>
#include <cstdint>

namespace typodont::debris {

/// The arrays of all particles, of equal length, in frame W and SI units.
struct Motion {
  float *x, *y, *z;     // m, frame W, positions of the particles
  float *vx, *vy, *vz;  // m/s, frame W, velocities of the particles
  // factor 1/(1 + rate·dt) by which drag (rate, 1/s) multiplies the velocity relative to the air in one step; 0 for a
  // particle at rest
  const float* keep;
};

/// Gravity and air flow that act on all particles.
struct Surroundings {
  float gravity[3];  // m/s², frame W, acceleration of gravity
  float sink[3];     // m, frame W, position of the suction nozzle
  // Strength of the suction in m³/s/sr (flow per solid angle); 0 if suction is off. At the distance r from the nozzle,
  // the air moves towards the nozzle at the speed strength/r².
  float strength = 0;
};

/// Moves particles first … last−1 by one step dt (semi-implicit Euler). Drag decelerates a particle with the velocity v
/// by rate·(v − air), where `rate` is the drag rate (1/s) and `air` the velocity of the air. So v ← keep·(v + g·dt) +
/// (1 − keep)·air (g: gravity), and the position p ← p + v·dt.
void move(const Motion& motion, std::size_t first, std::size_t last, float dt, const Surroundings& around) noexcept;

/// Reads and writes the same memory as move(), but computes almost nothing. So the running time of this function is a
/// lower bound for the running time of move().
void copy_through(const Motion& motion, std::size_t count) noexcept;

/// Returns the mean speed, in m/s, of the air at `distance` (m) from the nozzle during a step.
double mean_air_speed(double strength, double distance, double dt) noexcept;

/// Computes keep = 1/(1 + rate·dt) from each particle's drag rate (1/s) for a new step length dt (s).
void set_keep(const float* rate, float* keep, std::size_t count, float dt) noexcept;

/// Returns the drag of a ball divided by its Stokes drag: 1 + 0.15 Re^0.687 (Schiller & Naumann). The value comes from
/// a table with a relative error of 1e-4.
double drag_factor(double reynolds) noexcept;

/// Returns the drag rate (1/s) of a ball of diameter d and density ρ in air of viscosity μ. For Re < 1000, it is the
/// rate of Stokes drag, 18 μ/(ρ d²), times (1 + 0.15 Re^0.687) (Schiller & Naumann). For a larger Re, the drag
/// coefficient is 0.44.
double drag_rate(double speed, double diameter, double density, double air_density, double air_viscosity) noexcept;

}  // namespace typodont::debris
