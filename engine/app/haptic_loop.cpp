#include "engine/app/haptic_loop.h"

#include <cmath>

#include "engine/base/clock.h"

namespace typodont {

HapticLoop::HapticLoop(const Scene& scene, haptics::TissueVolume tissue, double rate)
    : carver_(std::move(tissue), haptics::tray(scene.servo)),
      servo_(servo_settings(scene, carver_.volume(), rate),
             haptics::patch_edge_for(haptics::tray(scene.servo), carver_.volume().frame().voxel)) {
  spare_.resize(servo_.patch().n);
}

bool HapticLoop::tick(const haptics::HandSample& hand, ServoTick& out, Cut& cut) {
  if (ticks_ == 0) last_.X_WT = last_.X_WG = hand.X_WT;  // the first patch lies where the hand is
  fresh_ = false;
  // Half a second in, and then every second.
  const bool stalled = held_ || std::fmod(to_seconds(hand.t) + 0.5, 1.0) < stall_;
  for (; !stalled && !waiting_.empty(); waiting_.pop_front()) carver_.apply(waiting_.front());
  if (!stalled && is_finite(last_.X_WG.p) && carver_.patch_due(last_)) {
    const dvec3 center_W = carver_.patch_center(last_);
    carver_.cut_out(center_W, spare_);
    use_ = {spare_.number, ticks_, spare_.cuts, center_W};
    fresh_ = true;
    servo_.adopt(spare_);
  }
  const Nanos start = thread_cpu_time();
  const bool did_cut = servo_.tick(hand, out, cut);
  out.cpu_time = thread_cpu_time() - start;
  ++ticks_;
  if (did_cut && stalled) waiting_.push_back(cut);
  if (did_cut && !stalled) carver_.apply(cut);
  last_ = out;
  return did_cut;
}

void HapticLoop::run(haptics::HapticDevice& hand, const std::function<void(const ServoTick&, const Cut*)>& each) {
  haptics::HandSample sample;
  ServoTick tick_out;
  Cut cut;
  while (hand.read(sample)) {
    sample.faults = hand.faults();
    const bool did_cut = tick(sample, tick_out, cut);
    hand.write(tick_out.f_T_W, tick_out.tau_T_W);
    each(tick_out, did_cut ? &cut : nullptr);
  }
  for (; !waiting_.empty(); waiting_.pop_front()) carver_.apply(waiting_.front());
}

}  // namespace typodont
