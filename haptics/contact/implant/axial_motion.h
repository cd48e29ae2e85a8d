// Motion along the axis of an implant bed (the drilled hole): eqs. 3–5 (coupling), 7–10 (step limits) of Zhao 2020.
#pragma once

#include <algorithm>

namespace typodont::haptics::implant {

/// Axial motion of a mass with spring and drag. SI.
struct AxialState {
  double speed = 0;  // m/s, speed along the axis
};

/// Returns the motion in m during `dt` s. A spring of stiffness `k` (N/m) pulls to the hand, `ahead` m away. `mass`:
/// kg; 0: spring and drag balance. `drag`: N·s/m. Eq. 5 of Zhao 2020 by implicit Euler, stable for all k and dt.
inline double coupled_step(double ahead, double k, double mass, double drag, double dt, AxialState& state) noexcept {
  const double force = k * ahead - drag * state.speed;
  const double inertia = mass + dt * drag + dt * dt * k;
  if (!(inertia > 0)) return 0;
  if (mass > 0) {
    state.speed += dt * (force - dt * k * state.speed) / inertia;
  } else {
    state.speed = dt * k * ahead / inertia;
  }
  return state.speed * dt;
}

/// Limits an axial step (eq. 7–9 of Zhao 2020, corrected): an obstacle limits only inward motion. `as_printed`: eq. 7
/// as in the paper, where the tool moves only at an obstacle. Lengths in m: `wanted` inward motion, `free` distance to
/// the obstacle, `step`: largest motion per tick.
inline double allowed_step(double wanted, double free, double step, bool has_obstacle, bool as_printed) noexcept {
  if (as_printed && !has_obstacle) return 0;
  if (wanted > 0 && !as_printed) wanted = std::min(wanted, std::max(free, 0.0));
  return std::clamp(wanted, -step, step);
}

}  // namespace typodont::haptics::implant
