// The inner loop over particles, compiled for several instruction sets with the same results.
#pragma once

#include <cstddef>
#include <cstdint>

namespace typodont::debris {

/// Arrays of equal length; frame W, SI units.
struct Motion {
  float *x, *y, *z;     // m
  float *vx, *vy, *vz;  // m/s
  // ratio of the velocity relative to the air after this step to that before it: 1/(1 + rate·dt); 0: at rest
  const float* keep;
};

/// Forces and air flow that act on all particles.
struct Surroundings {
  float gravity[3];  // m/s²
  float sink[3];     // m, position of the suction nozzle
  // m³/s/sr, strength of the suction; the air moves towards the sink at strength/r² and stops at the sink; 0: no
  // suction
  float strength = 0;
};

/// Advances particles first … last−1 by semi-implicit Euler with drag rate·(v − air): v ← keep·(v + g·dt) + (1 −
/// keep)·air, p ← p + v·dt.
void move(const Motion& motion, std::size_t first, std::size_t last, float dt, const Surroundings& around) noexcept;

/// Reads and writes the same memory as move() with almost no arithmetic: a lower bound for the cost of a step.
void copy_through(const Motion& motion, std::size_t count) noexcept;

/// Mean speed in m/s, during a step, of air at `distance` (m) from a sink.
double mean_air_speed(double strength, double distance, double dt) noexcept;

/// Computes keep = 1/(1 + rate·dt) for another step length.
void set_keep(const float* rate, float* keep, std::size_t count, float dt) noexcept;

/// Drag of a ball divided by its Stokes drag: 1 + 0.15 Re^0.687 (Schiller & Naumann), from a table with a relative
/// error of 1e-4.
double drag_factor(double reynolds) noexcept;

/// Drag rate in 1/s of a ball of diameter d at speed v in air: Stokes' 18 μ/(ρ d²) times Schiller & Naumann's 1 + 0.15
/// Re^0.687 (Re < 1000; above that, drag coefficient 0.44).
double drag_rate(double speed, double diameter, double density, double air_density, double air_viscosity) noexcept;

}  // namespace typodont::debris
