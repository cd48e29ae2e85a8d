// Along a bed's axis: coupling of eq. (3)–(5) and step limits of eq. (7)–(10), Zhao 2020.
#pragma once

#include <algorithm>

namespace typodont::haptics::implant {

/// A spring pulls, drag damps. SI.
struct AxialState {
  double speed = 0;  // m/s along the axis
};

/// m in `dt` (s), pulled over `ahead` (m) to the hand by `k` (N/m), with `mass` (kg), `drag` (N·s/m). Eq. (5) of Zhao
/// 2020, implicit Euler, stable for all k and dt: (mass + dt·drag + dt²·k) dv = dt (k·ahead - drag·v - dt·k·v). Mass 0:
/// where spring and drag balance at the tick's end.
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

/// Eq. (7)–(9) corrected: an obstacle limits the advance only. Printed eq. (7) has its cases exchanged (`as_printed`):
/// without an obstacle nothing moves. m: `wanted` inward, `free` to the obstacle, `step` per tick.
inline double allowed_step(double wanted, double free, double step, bool has_obstacle, bool as_printed) noexcept {
  if (as_printed && !has_obstacle) return 0;
  if (wanted > 0 && !as_printed) wanted = std::min(wanted, std::max(free, 0.0));
  return std::clamp(wanted, -step, step);
}

}  // namespace typodont::haptics::implant
