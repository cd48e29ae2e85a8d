// 16-bit counts to full counts, with jumps detected.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace typodont::haptics {

/// Right if it turns less than half the range between reports, which the arms never exceed.
class Encoder {
 public:
  /// Defines that the present reading corresponds to `count`.
  void home(std::int64_t count) noexcept {
    offset_ += count - value();
    slipped_ = false;
  }
  std::int64_t value() const noexcept { return total_ + offset_; }

  /// What Encoder::read16() did with a reading.
  enum class Step {
    kGood,
    // too far: ignored
    kRejected,
    // Counts lost: wrong until homed.
    kSlipped,
  };
  /// `reach`: counts since the last accepted reading; `nearby`: between successive ones.
  Step read16(std::int16_t reading, std::int64_t reach, std::int64_t nearby) noexcept {
    // Wraps around: the shorter rotation.
    return take(static_cast<std::int16_t>(static_cast<std::uint16_t>(reading) - static_cast<std::uint16_t>(total_)),
                reach, nearby);
  }
  Step read32(std::int32_t reading, std::int64_t reach, std::int64_t nearby) noexcept {
    return take(reading - total_, reach, nearby);
  }

  // agreeing far readings in a row
  static constexpr int kAcceptedAfter = 8;

 private:
  Step take(std::int64_t step, std::int64_t reach, std::int64_t nearby) noexcept {
    if (!started_) {
      started_ = true;
      total_ += step;
      return Step::kGood;
    }
    if (std::llabs(step) <= reach) {
      total_ += step;
      rejected_ = 0;
      return slipped_ ? Step::kSlipped : Step::kGood;
    }
    // Wrong reports would not agree: it really jumped.
    rejected_ = rejected_ > 0 && std::llabs(step - rejected_step_) <= nearby ? rejected_ + 1 : 1;
    rejected_step_ = step;
    if (rejected_ < kAcceptedAfter) return Step::kRejected;
    total_ += step;
    rejected_ = 0;
    slipped_ = true;
    return Step::kSlipped;
  }

  std::int64_t total_ = 0;
  std::int64_t offset_ = 0;
  std::int64_t rejected_step_ = 0;
  int rejected_ = 0;
  bool started_ = false;
  bool slipped_ = false;
};

}  // namespace typodont::haptics
