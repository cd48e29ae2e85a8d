// The inner loop over particles, compiled for several instruction sets with the same results.
#pragma once

#include <cstddef>
#include <cstdint>

namespace typodont::debris {

/// Arrays of the same length; W, SI.
struct Motion {
  float *x, *y, *z;     // m
  float *vx, *vy, *vz;  // m/s
  const float* keep;    // share of the velocity against the air kept in this step: 1/(1 + rate·dt); 0: at rest
};

/// What acts on all particles alike.
struct Surroundings {
  float gravity[3];    // m/s²
  float sink[3];       // m, where air is drawn to …
  float strength = 0;  // m³/s/sr: … at strength/r², and no farther than there; 0: air at rest
};

/// Semi-implicit Euler for particles first … last−1, drag being rate·(v − air): v ← keep·(v + g·dt) + (1 − keep)·air,
/// p ← p + v·dt.
void move(const Motion& motion, std::size_t first, std::size_t last, float dt, const Surroundings& around) noexcept;

/// The memory traffic of move() and hardly more: the least that a step can cost.
void copy_through(const Motion& motion, std::size_t count) noexcept;

/// m/s, the mean in a step of air so far from a sink, m.
double air_drawn(double strength, double distance, double dt) noexcept;

/// keep = 1/(1 + rate·dt), for a step of another length.
void set_keep(const float* rate, float* keep, std::size_t count, float dt) noexcept;

/// Drag of a ball over Stokes': 1 + 0.15 Re^0.687 (Schiller & Naumann), from a table true to 1e-4.
double drag_factor(double reynolds) noexcept;

/// Drag rate of a ball of diameter d moving at speed v through air: Stokes' 18 μ/(ρ d²) times Schiller & Naumann's
/// 1 + 0.15 Re^0.687 (Re < 1000; beyond, drag coefficient 0.44).
double drag_rate(double speed, double diameter, double density, double air_density, double air_viscosity) noexcept;

}  // namespace typodont::debris
