// Delays the force between servo and hand: a stimulus for experiments on the perception of delay. Servo thread; never
// allocates after construction.
#pragma once

#include <vector>

#include "engine/contract/contact.h"
#include "haptics/coupling/passivity.h"
#include "haptics/servo.h"

namespace typodont::haptics {

/// A delayed spring gives back more energy than it received, because it still pushes with an earlier force when the
/// hand retreats. So the delayed force has its own energy ledger, and the servo's passivity law limits the force by
/// this ledger.
class ForceDelay {
 public:
  struct Wrench {
    dvec3 f_T_W{0}, tau_T_W{0};  // N, N·m, on the hand
  };

  /// `settings`: settings of the servo whose force is delayed. `most`: s, limit of the delay in pass().
  ForceDelay(const ServoSettings& settings, double most);

  /// Call once per tick. Returns the force and torque that the servo computed at least `delay` ns ago; with a delay of
  /// 0, returns the tick's own force unchanged.
  Wrench pass(const ServoTick& tick, Nanos delay) noexcept;

 private:
  struct Row {
    Nanos t = 0;
    Wrench wrench;
  };
  double tick_;  // s, tick of the servo
  PassivityLaw law_;
  std::vector<Row> past_;  // ring of the last forces
  std::size_t newest_ = 0, count_ = 0;
  PassivityState state_;
  double energy_ = 0;  // J, energy received from the hand up to now
  Wrench sent_;
  Pose X_WT_;
  Nanos t_ = 0;
  bool begun_ = false;
};

}  // namespace typodont::haptics
