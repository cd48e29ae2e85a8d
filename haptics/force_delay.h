// A force that reaches the hand later than the servo computed it: a stimulus for experiments on how late a force is
// felt to be. Servo thread; never allocates after construction.
#pragma once

#include <vector>

#include "engine/contract/contact.h"
#include "haptics/coupling/passivity.h"
#include "haptics/servo.h"

namespace typodont::haptics {

/// A delayed spring gives back more energy than was put in: on the way out it still pushes with the force of a moment
/// ago. So the delayed force has an energy ledger of its own, and the servo's passivity law limits it by that ledger.
class ForceDelay {
 public:
  struct Wrench {
    dvec3 f_T_W{0}, tau_T_W{0};  // N, N·m, on the hand
  };

  /// `settings`: those of the servo whose force is delayed. `most`: s, the greatest delay that pass() is asked for.
  ForceDelay(const ServoSettings& settings, double most);

  /// Once a tick: the force and torque that the servo computed at least `delay` ns ago. 0 gives the tick's own, as it
  /// is.
  Wrench pass(const ServoTick& tick, Nanos delay) noexcept;

 private:
  struct Row {
    Nanos t = 0;
    Wrench wrench;
  };
  double tick_;  // s, of the servo
  PassivityLaw law_;
  std::vector<Row> past_;  // a ring
  std::size_t newest_ = 0, count_ = 0;
  PassivityState state_;
  double energy_ = 0;  // J, taken from the hand so far
  Wrench sent_;
  Pose X_WT_;
  Nanos t_ = 0;
  bool begun_ = false;
};

}  // namespace typodont::haptics
