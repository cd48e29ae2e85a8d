// Vibration of a turning spindle, which the arm transmits to the hand. Imbalance and run-out of the bur cause one
// oscillation per revolution; the cut causes one oscillation per cutting edge. Frequencies that the device cannot
// render are omitted. Pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/pose.h"
#include "engine/base/units.h"

namespace typodont::haptics {

/// Law of the vibration force; amplitudes in N. A component with a frequency above `band` is omitted, because aliasing
/// would produce a frequency that the drill does not have. So at 300 krpm (5 kHz), a device with an update rate of 1
/// kHz renders the vibration only while the spindle speeds up or slows down.
struct VibrationLaw {
  // Hz, highest frequency that the device renders; 0: no vibration. The value comes from DeviceInfo or the
  // scene.
  double band = 0;
  double rotor_mass = 5e-3;  // kg, mass of bur, chuck and rotor
  double balance = 6.3e-3;   // m/s, eccentricity × speed: balance quality grade G 6.3 of ISO 21940-11
  double run_out = 0.25;     // fraction of the tangential cutting force that oscillates once per revolution
  // Fraction of the tangential cutting force that oscillates once per cutting edge (tooth of the bur). There is no
  // measurement; the value follows milling, where the force varies in this way when few edges are in contact.
  double teeth = 0.12;
  int tooth_count = 6;  // number of cutting edges; burs of ISO 6360 have 6 to 8 blades
};

/// Returns the weight of a vibration component: 1 well below the highest frequency of the device (`band`), falling to 0
/// at this frequency. So no component starts or stops abruptly while the spindle runs up.
inline double band_weight(double frequency, double band) noexcept {
  if (!(band > 0)) return 0;
  const double x = std::clamp((1 - std::abs(frequency) / band) / 0.2, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

/// Returns the spindle's angle (rad, modulo 2π) after a rotation at `speed` (rad/s) for `dt` (s). The number of cutting
/// edges is an integer, so their oscillation has no jump when the angle changes from 2π to 0.
inline double advance_phase(double phase, double speed, double dt) noexcept {
  return std::fmod(phase + speed * dt, 2 * kPi);
}

/// Returns the vibration force on the tool (N, workbench frame W). `band`: Hz, law.band, but limited according to the
/// servo's rate; `phase`: rad, angle of the spindle; `speed`: rad/s; `axis`: direction of the shank; `normal`:
/// direction out of the tissue, zero without contact; `cutting`: N, tangential force of the cutting edges, the same as
/// for the sound.
inline dvec3 vibration_force(const VibrationLaw& law, double band, double phase, double speed, const dvec3& axis,
                             const dvec3& normal, double cutting) noexcept {
  const double once = band_weight(speed / (2 * kPi), band);
  const double tooth = band_weight(law.tooth_count * speed / (2 * kPi), band);
  if (once <= 0) return dvec3(0);
  // The force of the imbalance rotates with the spindle: m e ω² = m (e ω) ω; m: rotor mass, e: eccentricity.
  const dvec3 aside = std::abs(axis.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 u = glm::normalize(glm::cross(axis, aside)), v = glm::cross(axis, u);
  const double unbalance = law.rotor_mass * law.balance * std::abs(speed) * once;
  dvec3 f = unbalance * (std::cos(phase) * u + std::sin(phase) * v);
  // The force of the cutting edges oscillates. This oscillation pushes the head away from the tissue and lets it
  // return.
  if (cutting > 0) {
    f += cutting * (law.run_out * once * std::sin(phase) + law.teeth * tooth * std::sin(law.tooth_count * phase)) *
         normal;
  }
  return f;
}

}  // namespace typodont::haptics
