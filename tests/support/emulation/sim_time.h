// Simulated time for tests of devices: it moves only when someone waits, and everyone who lives in it is told.
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "engine/base/clock.h"

namespace typodont::test {

class SimTime {
 public:
  static constexpr Nanos kStep = 100'000;  // ns: the finest thing seen

  Nanos now() const { return now_ + skew_; }
  /// What everything but clocks sees: never steps.
  Nanos true_now() const { return now_; }
  /// The clock jumps; nothing else happens.
  void step_clock(Nanos by) { skew_ += by; }

  void advance(Nanos by) {
    for (const Nanos end = now_ + by; now_ < end;) {
      now_ = std::min(end, now_ + kStep);
      for (const auto& resident : residents_) resident();
    }
  }
  void on_step(std::function<void()> resident) { residents_.push_back(std::move(resident)); }

 private:
  Nanos now_ = kNanosPerSecond;
  Nanos skew_ = 0;
  std::vector<std::function<void()>> residents_;
};

}  // namespace typodont::test
