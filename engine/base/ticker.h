// Times of a hand's samples. Servo thread.
#pragma once

#include <cstdint>

#include "engine/base/clock.h"
#include "engine/base/realtime.h"

namespace typodont {

/// Sample i has the time i / rate, ns. If `paced`, next() waits until this time has passed since its first call.
class Ticker {
 public:
  explicit Ticker(double rate, bool paced = true) : rate_(rate), paced_(paced) {}
  Nanos next() noexcept {
    const Nanos t = from_seconds(static_cast<double>(index_++) / rate_);
    if (paced_) {
      if (index_ == 1) start_ = now();
      sleep_until(start_ + t);
    }
    return t;
  }

 private:
  double rate_;
  bool paced_;
  std::uint64_t index_ = 0;
  Nanos start_ = 0;
};

}  // namespace typodont
