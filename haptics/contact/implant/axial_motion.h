// Motion of a tool along a bed's axis (a bed is the hole for an implant): the virtual coupling of eq. (3)–(5) of Zhao
// 2020, and the step limits of eq. (7)–(10).
#pragma once

#include <algorithm>

namespace typodont::haptics::implant {

/// State of the virtual tool. A spring pulls it along the bed's axis, and a drag force damps its motion. SI units.
struct AxialState {
  double speed = 0;  // m/s, speed of the virtual tool along the bed's axis
};

/// Returns the displacement (m) of the virtual tool along the bed's axis in the time `dt` (s). A spring pulls the
/// virtual tool towards the hand, which is farther along the axis by `ahead` (m). `k`: spring stiffness (N/m); `mass`
/// in kg; `drag`: viscous friction (N·s/m). The function integrates eq. (5) of Zhao 2020 by one step of the implicit
/// Euler method, so it is stable for every k and dt. Each step solves (mass + dt·drag + dt²·k) dv = dt (k·ahead -
/// drag·v - dt·k·v), where v is the speed and dv its change. If the mass is 0, the tool moves to the point where the
/// forces of spring and drag are equal at the end of the tick.
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

/// Applies eq. (7)–(9) of Zhao 2020 in a corrected form: an obstacle limits the advance, but never the withdrawal. In
/// the paper, the two cases of eq. (7) are exchanged, so a tool without an obstacle would not move; `as_printed` = true
/// selects that version. `wanted`: requested motion along the axis, positive inward, m; `free`: distance to the
/// obstacle, m; `step`: largest motion per tick, m.
inline double allowed_step(double wanted, double free, double step, bool has_obstacle, bool as_printed) noexcept {
  if (as_printed && !has_obstacle) return 0;
  if (wanted > 0 && !as_printed) wanted = std::min(wanted, std::max(free, 0.0));
  return std::clamp(wanted, -step, step);
}

}  // namespace typodont::haptics::implant
