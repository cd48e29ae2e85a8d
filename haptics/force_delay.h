// Delays the force, as a stimulus for experiments. Servo thread; allocates only in the constructor.
#pragma once

#include <vector>

#include "engine/contract/contact.h"
#include "haptics/coupling/passivity.h"
#include "haptics/servo.h"

namespace typodont::haptics {

/// A delayed spring generates energy, because it pushes a retreating hand with an earlier, larger force. So the delayed
/// force has its own energy ledger, and the servo's passivity law limits it.
class ForceDelay {
 public:
  struct Wrench {
    dvec3 f_T_W{0}, tau_T_W{0};  // force (N) and torque (N·m) on the hand
  };

  /// `settings`: settings of the servo. `most`: largest delay that will be passed to pass(), s.
  ForceDelay(const ServoSettings& settings, double most);

  /// Call once per tick. Returns force and torque of the newest tick that is at least `delay` (ns) old. If `delay` is
  /// 0, returns those of `tick` unchanged.
  Wrench pass(const ServoTick& tick, Nanos delay) noexcept;

 private:
  struct Row {
    Nanos t = 0;
    Wrench wrench;
  };
  double tick_;  // s, period of a servo tick
  PassivityLaw law_;
  std::vector<Row> past_;  // ring buffer of the most recent forces
  std::size_t newest_ = 0, count_ = 0;
  PassivityState state_;
  double energy_ = 0;  // J, energy that the delayed force has received from the hand, minus the energy given to it
  Wrench sent_;
  Pose X_WT_;
  Nanos t_ = 0;
  bool begun_ = false;
};

}  // namespace typodont::haptics
