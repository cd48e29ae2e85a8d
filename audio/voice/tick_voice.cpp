#include "audio/tick_voice.h"

#include <algorithm>
#include <numeric>

namespace typodont::audio {

SoundState TickVoice::state_of(const ServoTick& tick) noexcept {
  const Seen now{tick.t, std::accumulate(tick.removed.begin(), tick.removed.end(), 0.0), tick.X_WG.p};
  seen_[count_++ % kSeen] = now;
  if (count_ - back_ > kSeen) ++back_;
  while (back_ + 1 < count_ && seen_[(back_ + 1) % kSeen].t <= now.t - kDifferenceOver) ++back_;
  const Seen before = seen_[back_ % kSeen];

  SoundState state;
  state.t = tick.t;
  state.spindle = tick.spindle;
  state.pedal = tick.pedal;
  state.contact_area = tick.contact_area;
  state.tissue = tick.tissue;
  state.cutting_tool = tick.tool >= tools_cut_.size() || tools_cut_[tick.tool];
  const double elapsed = to_seconds(now.t - before.t);
  if (elapsed > 0) {
    state.removal_rate = std::max(0.0, now.removed - before.removed) / elapsed;
    const dvec3 v = (now.p_WG - before.p_WG) / elapsed;
    state.slip_speed = glm::length(v - tick.n_C_W * glm::dot(v, tick.n_C_W));
  }
  // Force without contact comes from inertia and damping, which are silent.
  if (tick.contact_area > 0 || state.removal_rate > 0) state.force = glm::length(tick.f_T_W);
  return state;
}

}  // namespace typodont::audio
