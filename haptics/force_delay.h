// Delays the force between servo and hand, as a stimulus for experiments on the perception of delay. Servo thread;
// never allocates after construction.
#pragma once

#include <vector>

#include "engine/contract/contact.h"
#include "haptics/coupling/passivity.h"
#include "haptics/servo.h"

namespace typodont::haptics {

/// Delays forces. A delayed spring is not passive: while the hand retreats, the spring still pushes with an earlier,
/// larger force, and so returns more energy than it received. Therefore the delayed force has an energy ledger of its
/// own. With this ledger, the servo's passivity law limits the delayed force.
class ForceDelay {
 public:
  struct Wrench {
    dvec3 f_T_W{0}, tau_T_W{0};  // force (N) and torque (N·m) on the hand
  };

  /// `settings`: settings of the servo whose force is delayed. `most`: largest delay for pass(), s.
  ForceDelay(const ServoSettings& settings, double most);

  /// Must be called once per tick. Returns the force and torque of the newest tick that is at least `delay` (ns) old.
  /// With a delay of 0, returns the force of `tick` unchanged.
  Wrench pass(const ServoTick& tick, Nanos delay) noexcept;

 private:
  struct Row {
    Nanos t = 0;
    Wrench wrench;
  };
  double tick_;  // s, period of a servo tick
  PassivityLaw law_;
  std::vector<Row> past_;  // ring buffer of the last forces
  std::size_t newest_ = 0, count_ = 0;
  PassivityState state_;
  double energy_ = 0;  // J, balance of the energy ledger: energy that the hand has given to the delayed force so far
  Wrench sent_;
  Pose X_WT_;
  Nanos t_ = 0;
  bool begun_ = false;
};

}  // namespace typodont::haptics
