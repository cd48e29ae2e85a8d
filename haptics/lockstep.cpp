#include "haptics/lockstep.h"

#include <limits>
#include <utility>

namespace typodont::haptics {

namespace {

ServoSettings in_frame(ServoSettings settings, const VoxelFrame& frame) {
  settings.frame = frame;
  return settings;
}

}  // namespace

LockStep::LockStep(TissueVolume tissue, ServoSettings settings)
    : settings_(in_frame(std::move(settings), tissue.frame())),
      carver_(std::move(tissue), settings_),
      servo_(settings_),
      spare_(carver_.make_snapshot()) {}

bool LockStep::tick(const HandSample& hand, ServoTick& out, Cut& cut) {
  if (ticks_ == 0) last_.X_WT = last_.X_WG = hand.X_WT;  // the first snapshot lies where the hand is
  fresh_ = false;
  if (!stalled_) {
    apply_cuts(std::numeric_limits<std::uint64_t>::max());
    if (is_finite(last_.X_WG.p) && carver_.snapshot_due(last_)) {
      take_snapshot(carver_.snapshot_center(last_));
      adopt_snapshot();
    }
  }
  const bool removed = tick_servo(hand, out, cut);
  if (!stalled_) apply_cuts(std::numeric_limits<std::uint64_t>::max());
  return removed;
}

void LockStep::apply_cuts(std::uint64_t through) {
  for (; !waiting_.empty() && waiting_.front().index <= through; waiting_.pop_front()) carver_.apply(waiting_.front());
}

void LockStep::adopt_snapshot() {
  use_ = {spare_->number, ticks_, spare_->cuts, spare_->center_W};
  fresh_ = true;
  servo_.adopt(*spare_);
}

bool LockStep::tick_servo(const HandSample& hand, ServoTick& out, Cut& cut) {
  const Nanos start = thread_cpu_time();
  const bool removed = servo_.tick(hand, out, cut);
  out.cpu_time = thread_cpu_time() - start;
  ++ticks_;
  if (removed) waiting_.push_back(cut);
  last_ = out;
  return removed;
}

}  // namespace typodont::haptics
