// The virtual coupling of eq. (3)–(5) of Zhao 2020 along one line, and the step limits of eq. (7)–(10).
#pragma once

#include <algorithm>

namespace typodont::haptics::implant {

/// A virtual tool on a line, pulled by a spring and damped by drag. SI.
struct AxialState {
  double speed = 0;  // m/s
};

/// Displacement in m of the tool in `dt` towards a hand at distance `ahead` (m): spring `k` (N/m), mass `m` (kg), drag
/// (N·s/m). Implicit Euler of eq. (5), (m I - h D - h² K) dv = h (f + h K v) with f = k·ahead - drag·v, which is stable
/// for every k and h. Without a mass the result is the balance of spring and drag at the end of the tick.
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

/// Eq. (7)–(9), corrected: an obstacle limits the advance, but never the withdrawal. The printed equation has the two
/// cases exchanged: with it, a tool without an obstacle does not move. `wanted`: m, wanted motion along the axis,
/// inward; `free`: m, distance to the obstacle; `step`: m, largest step in a tick.
inline double allowed_step(double wanted, double free, double step, bool has_obstacle, bool as_printed) noexcept {
  if (as_printed && !has_obstacle) return 0;
  if (wanted > 0 && !as_printed) wanted = std::min(wanted, std::max(free, 0.0));
  return std::clamp(wanted, -step, step);
}

}  // namespace typodont::haptics::implant
