#include "haptics/contact/missing_snapshot.h"

#include <algorithm>

namespace typodont::haptics {

bool MissingSnapshot::bridge(const ContactInput& in, const Motion& motion, dvec3& c, SnapshotGap& gap) noexcept {
  using P = MissingSnapshotParameters;
  const auto& [unit, voxel, travel, start, target, step_per_slew] = motion;
  // A head that moves a voxel or more per tick does not wait for a snapshot, although the hand is faster than the
  // snapshots.
  const bool moves_on = travel >= voxel && glm::length(target - c) * unit <= P::longest_lag;
  lost_for_ = gap.lost && !moves_on ? lost_for_ + in.dt : 0;
  gap.late = lost_for_ > P::wait;
  gap.bridging = gap.lost && in.last.normal_force > 0;
  if (!(gap.bridging && gap.late)) push_ = 0;
  if (gap.bridging) {
    double under = glm::dot(start - target, in.last.normal);
    if (gap.late) {
      if (push_ == 0) push_ = in.last.normal_force, from_ = start;
      const double moved = glm::length(start - from_) * unit;
      // largest distance of the plane from the hand
      const double most = std::clamp(2 - moved / P::reach, 0.0, 1.0) * (push_ + P::yield) * step_per_slew / in.dt;
      under = std::min(under, most);
    }
    c = under > 0 ? target + under * in.last.normal : target;
  } else if (gap.late) {
    c = target;
  }
  return gap.bridging || gap.late;
}

}  // namespace typodont::haptics
