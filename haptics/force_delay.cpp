#include "haptics/force_delay.h"

#include <algorithm>
#include <cmath>

#include "haptics/servo/state.h"

namespace typodont::haptics {

ForceDelay::ForceDelay(const ServoSettings& settings, double most)
    : tick_(settings.tick), law_(law_for(settings)), past_(static_cast<std::size_t>(std::ceil(most / tick_)) + 2) {}

ForceDelay::Wrench ForceDelay::pass(const ServoTick& tick, Nanos delay) noexcept {
  newest_ = (newest_ + 1) % past_.size();
  past_[newest_] = {tick.t, {tick.f_T_W, tick.tau_T_W}};
  count_ = std::min(count_ + 1, past_.size());

  // Energy that the last delayed force has given to the hand since the last tick.
  const dvec3 moved = begun_ ? tick.X_WT.p - X_WT_.p : dvec3(0);
  const dvec3 turned = begun_ ? rotation_vector(X_WT_.R, tick.X_WT.R) : dvec3(0);
  const double dt = begun_ ? std::max(to_seconds(tick.t - t_), 0.0) : tick_;
  energy_ -= glm::dot(sent_.f_T_W, moved) + glm::dot(sent_.tau_T_W, turned);
  X_WT_ = tick.X_WT, t_ = tick.t, begun_ = true;

  Wrench wrench{tick.f_T_W, tick.tau_T_W};
  if (delay > 0) {
    wrench = {};  // zero until the oldest force is old enough
    for (std::size_t i = 0; i < count_; ++i) {
      const Row& row = past_[(newest_ + past_.size() - i) % past_.size()];
      if (tick.t - row.t < delay) continue;
      wrench = row.wrench;
      break;
    }
  }
  // If both the delayed and the current force are zero, contact has ended, and negative `energy_` is cancelled.
  if (wrench.f_T_W == dvec3(0) && tick.f_T_W == dvec3(0)) energy_ = std::max(energy_, 0.0);
  const double fraction =
      passive_fraction(law_, wrench.f_T_W, moved, wrench.tau_T_W, turned, dt > 0 ? dt : tick_, tick_, energy_, state_);
  // Without delay, the servo has already applied the passivity law.
  if (delay > 0) wrench.f_T_W *= fraction, wrench.tau_T_W *= fraction;
  return sent_ = wrench;
}

}  // namespace typodont::haptics
