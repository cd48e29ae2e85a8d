// Simulated time for tests of devices. It advances only while a thread waits, and notifies all registered objects.
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "engine/base/clock.h"

namespace typodont::test {

class SimTime {
 public:
  static constexpr Nanos kStep = 100'000;  // ns, time resolution

  Nanos now() const { return now_ + skew_; }
  /// Returns the true time, which never jumps.
  Nanos true_now() const { return now_; }
  /// Makes the clock jump without any other effect.
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
