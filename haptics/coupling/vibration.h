// Once per revolution by imbalance and run-out, once per edge by the cut. Without frequencies that the device cannot
// render. Pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/pose.h"
#include "engine/base/units.h"

namespace typodont::haptics {

/// N. Above `band` aliasing would make frequencies that the drill lacks: at 300 krpm (5 kHz), a 1 kHz device vibrates
/// only while the spindle changes speed.
struct VibrationLaw {
  // Hz, by DeviceInfo or scene; 0: none.
  double band = 0;
  double rotor_mass = 5e-3;  // kg, mass of bur, chuck and rotor
  double balance = 6.3e-3;   // m/s, eccentricity × speed: grade G 6.3, ISO 21940-11
  double run_out = 0.25;     // of the tangential force, per revolution
  // of the tangential force, per edge; unmeasured, as in milling with few edges
  double teeth = 0.12;
  int tooth_count = 6;  // ISO 6360: 6 to 8 blades
};

/// 1 well below `band`, 0 at it: nothing starts abruptly in the run-up.
inline double band_weight(double frequency, double band) noexcept {
  if (!(band > 0)) return 0;
  const double x = std::clamp((1 - std::abs(frequency) / band) / 0.2, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

/// rad, modulo 2π, after `dt` (s) at `speed` (rad/s). Whole numbers of edges do not jump at 2π.
inline double advance_phase(double phase, double speed, double dt) noexcept {
  return std::fmod(phase + speed * dt, 2 * kPi);
}

/// N on the tool, W. `band`: Hz, limited by the servo's rate; `phase`: rad; `speed`: rad/s; `axis`: of the shank;
/// `normal`: outwards, zero without contact; `cutting`: N, as for the sound.
inline dvec3 vibration_force(const VibrationLaw& law, double band, double phase, double speed, const dvec3& axis,
                             const dvec3& normal, double cutting) noexcept {
  const double once = band_weight(speed / (2 * kPi), band);
  const double tooth = band_weight(law.tooth_count * speed / (2 * kPi), band);
  if (once <= 0) return dvec3(0);
  // Turns with the spindle: m e ω² = m (e ω) ω.
  const dvec3 aside = std::abs(axis.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 u = glm::normalize(glm::cross(axis, aside)), v = glm::cross(axis, u);
  const double unbalance = law.rotor_mass * law.balance * std::abs(speed) * once;
  dvec3 f = unbalance * (std::cos(phase) * u + std::sin(phase) * v);
  // Pushes the head off and lets it return.
  if (cutting > 0) {
    f += cutting * (law.run_out * once * std::sin(phase) + law.teeth * tooth * std::sin(law.tooth_count * phase)) *
         normal;
  }
  return f;
}

}  // namespace typodont::haptics
