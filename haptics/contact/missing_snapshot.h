// What happens while the tool is outside the servo's snapshot of the tissue. `offset` uses it for its proxy, the servo
// for penalty methods (Servo::State::bridge_springs).
#pragma once

#include "haptics/contact/contact_model.h"

namespace typodont::haptics {

struct MissingSnapshotParameters {
  // s; a new snapshot is late if the head has been outside the old one for longer than this
  static constexpr double wait = 0.01;
  // m; if a fast hand is less than this ahead of a moving proxy, a missing snapshot is not late. A hand that is farther
  // ahead has jumped.
  static constexpr double longest_lag = 20e-3;
  // m; after this motion of the head with a late snapshot, the force of the plane that replaces the tissue decreases
  static constexpr double reach = 5e-3;
  // N; the plane that replaces the tissue yields if the force exceeds the last contact force by more than this
  static constexpr double yield = 0.5;
  // N/s, largest rate at which the force of a penalty method returns with the new snapshot
  static constexpr double return_slew = 14;
};

/// Replaces missing tissue by the plane of the last contact until a new snapshot arrives (Adachi 1995, Mark 1996). If
/// the snapshot is late, the plane moves back under larger forces, and its force decreases to zero between one and two
/// times `reach`. Measurements: docs/safety.md. Servo thread only.
class MissingSnapshot {
 public:
  /// Motion of the head's centre in this tick.
  struct Motion {
    double unit;          // m, unit of all other lengths
    double voxel;         // size of a voxel
    double travel;        // distance that the head moves in this tick
    dvec3 start, target;  // at the start of the tick; at the hand's pose
    // change of the distance between hand and proxy in this tick if the force changes at a rate of 1 N/s
    double step_per_slew;
  };

  /// Call in every tick. `c`: the head's centre; moved if a plane replaces the tissue, or if the snapshot is late.
  /// Reads gap.lost, sets the rest of `gap` except `rejoining`. Returns true if the head has no contact because tissue
  /// is missing.
  bool bridge(const ContactInput& in, const Motion& motion, dvec3& c, SnapshotGap& gap) noexcept;
  /// Call when the tool is far from all tissue.
  void forget() noexcept { lost_for_ = 0; }

 private:
  double lost_for_ = 0;  // s, time that the tool has been outside its snapshot
  // N, contact force when a new snapshot became overdue; 0: none is overdue
  double push_ = 0;
  dvec3 from_{0};  // the head's centre when a new snapshot became overdue
};

}  // namespace typodont::haptics
