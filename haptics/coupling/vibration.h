// Vibration of a drill: once per revolution from imbalance and run-out, once per cutting edge from the cut. Frequencies
// that the device cannot render are omitted. Pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/pose.h"
#include "engine/base/units.h"

namespace typodont::haptics {

/// Above `band`, aliasing would produce frequencies that the drill does not have. At 300 krpm (5 kHz), a 1 kHz device
/// vibrates only while the spindle changes its speed.
struct VibrationLaw {
  // Hz, highest frequency of the vibration, from DeviceInfo or the scene; 0: no vibration.
  double band = 0;
  double rotor_mass = 5e-3;  // kg, mass of bur, chuck and rotor
  double balance = 6.3e-3;   // m/s, eccentricity × angular speed: grade G 6.3, ISO 21940-11
  double run_out = 0.25;     // amplitude of the force once per revolution divided by the tangential cutting force
  // amplitude of the force that each passing edge causes / tangential cutting force; estimate from milling
  double teeth = 0.12;
  int tooth_count = 6;  // number of cutting edges; ISO 6360: 6 to 8 blades
};

/// Weight of a frequency: 1 well below `band`, 0 at `band`, so that the vibration ends gradually as speed rises.
inline double band_weight(double frequency, double band) noexcept {
  if (!(band > 0)) return 0;
  const double x = std::clamp((1 - std::abs(frequency) / band) / 0.2, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

/// Phase in rad, modulo 2π, after `dt` (s) at `speed` (rad/s). The number of edges is an integer: no jump at 2π.
inline double advance_phase(double phase, double speed, double dt) noexcept {
  return std::fmod(phase + speed * dt, 2 * kPi);
}

/// Force on the tool in N, frame W. `band`: Hz, also limited by the servo's rate. `phase`: rad. `speed`: rad/s. `axis`:
/// shank's axis. `normal`: out of the tissue, zero without contact. `cutting`: tangential cutting force, N.
inline dvec3 vibration_force(const VibrationLaw& law, double band, double phase, double speed, const dvec3& axis,
                             const dvec3& normal, double cutting) noexcept {
  const double once = band_weight(speed / (2 * kPi), band);
  const double tooth = band_weight(law.tooth_count * speed / (2 * kPi), band);
  if (once <= 0) return dvec3(0);
  // Centrifugal force of the imbalance, which rotates with the spindle: rotor_mass × balance × speed.
  const dvec3 aside = std::abs(axis.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 u = glm::normalize(glm::cross(axis, aside)), v = glm::cross(axis, u);
  const double unbalance = law.rotor_mass * law.balance * std::abs(speed) * once;
  dvec3 f = unbalance * (std::cos(phase) * u + std::sin(phase) * v);
  // Once per revolution and once per edge, pushes the head away from the tissue and lets it return.
  if (cutting > 0) {
    f += cutting * (law.run_out * once * std::sin(phase) + law.teeth * tooth * std::sin(law.tooth_count * phase)) *
         normal;
  }
  return f;
}

}  // namespace typodont::haptics
