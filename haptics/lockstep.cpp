#include "haptics/lockstep.h"

#include <utility>

#include "haptics/servo/parameters.h"

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
  if (ticks_ == 0) placed_.X_WT = placed_.X_WG = hand.X_WT;  // the first snapshot is centred at the hand
  fresh_ = false;
  if (!stalled_) {
    follow_servo();
    if (in_workspace(placed_.X_WG.p) && carver_.snapshot_due(placed_)) {
      take_snapshot(carver_.snapshot_center(placed_));
      adopt_snapshot();
    }
  }
  const bool removed = tick_servo(hand, out, cut);
  if (removed && !stalled_) follow_servo();
  return removed;
}

void LockStep::follow_servo() {
  for (; !waiting_.empty() && !carver_.edited(); waiting_.pop_front()) carver_.apply(waiting_.front());
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
  placed_.t = out.t, placed_.X_WT.p = out.X_WT.p, placed_.X_WG.p = out.X_WG.p;
  return removed;
}

}  // namespace typodont::haptics
