// What a turning spindle sends through the arm into the hand: once a turn from what is out of balance and from the
// teeth that run out, and once a tooth from the cut, as far as the device can render it. Pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/pose.h"
#include "engine/base/units.h"

namespace typodont::haptics {

/// Amplitudes in N. A component above the band is left out, never folded down to a frequency that is not the drill's:
/// at 300 krpm (5 kHz) a kilohertz arm renders nothing but run-up and run-down, and that is what it should.
struct VibrationLaw {
  double band = 0;           // Hz that the device renders; 0: none. A property of the device (DeviceInfo), or asked
                             // for by the scene
  double rotor_mass = 5e-3;  // kg, bur, chuck and rotor
  double balance = 6.3e-3;   // m/s, eccentricity × speed: balance quality grade G 6.3 of ISO 21940-11
  double run_out = 0.25;     // share of the tangential cutting force that swings once a turn …
  double teeth = 0.12;       // … and once a tooth; ripples of milling forces with few teeth engaged (our choice)
  int tooth_count = 6;       // ISO 6360 burs: 6 to 8 blades
};

/// 1 well inside the band, 0 at its end; no component is switched on or off at once while the spindle runs up.
inline double share_in_band(double frequency, double band) noexcept {
  if (!(band > 0)) return 0;
  const double x = std::clamp((1 - std::abs(frequency) / band) / 0.2, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

/// The phase advances by the spindle's speed; kept between 0 and 2π. With six teeth the sixth harmonic stays exact.
inline double advance_phase(double phase, double speed, double dt) noexcept {
  return std::fmod(phase + speed * dt, 2 * kPi);
}

/// N on the tool, W. `axis`: the shank; `normal`: out of the tissue, zero when free; `cutting`: the tangential force of
/// the teeth, N, from the same contact as the sound's; `band`: what of law.band the servo's rate leaves.
inline dvec3 vibration_force(const VibrationLaw& law, double band, double phase, double speed, const dvec3& axis,
                             const dvec3& normal, double cutting) noexcept {
  const double once = share_in_band(speed / (2 * kPi), band);
  const double tooth = share_in_band(law.tooth_count * speed / (2 * kPi), band);
  if (once <= 0) return dvec3(0);
  // What is out of balance turns with the spindle: m e ω² = m (e ω) ω.
  const dvec3 aside = std::abs(axis.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 u = glm::normalize(glm::cross(axis, aside)), v = glm::cross(axis, u);
  const double unbalance = law.rotor_mass * law.balance * std::abs(speed) * once;
  dvec3 f = unbalance * (std::cos(phase) * u + std::sin(phase) * v);
  // The cut's ripple pushes the head off the tissue and lets it come back.
  if (cutting > 0) {
    f += cutting * (law.run_out * once * std::sin(phase) + law.teeth * tooth * std::sin(law.tooth_count * phase)) *
         normal;
  }
  return f;
}

}  // namespace typodont::haptics
