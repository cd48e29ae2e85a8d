// Extends the 16-bit counts of incremental encoders to full counts, and detects jumps.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace typodont::haptics {

/// The full count of one encoder. It is correct if the encoder turns by less than half of its 16-bit range between two
/// reports. The encoders of the supported arms never turn by so much, even across the whole workspace of the arm.
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
    // this reading is too far from the last one, so it counts as wrong, and the count does not change
    kRejected,
    // Several readings were too far away, so counts were lost. The position is wrong until the arm is
    // homed.
    kSlipped,
  };
  /// Processes a reading. `reach` is the largest possible change, in counts, since the last accepted reading. `nearby`
  /// is the largest possible change between two successive readings.
  Step read16(std::int16_t reading, std::int64_t reach, std::int64_t nearby) noexcept {
    // The 16-bit difference wraps around, so it is the shorter of the two possible rotations.
    return take(static_cast<std::int16_t>(static_cast<std::uint16_t>(reading) - static_cast<std::uint16_t>(total_)),
                reach, nearby);
  }
  Step read32(std::int32_t reading, std::int64_t reach, std::int64_t nearby) noexcept {
    return take(reading - total_, reach, nearby);
  }

  // Readings that are far from the last accepted one, but agree with each other, are accepted after this number in a
  // row.
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
    // If several readings are far from the last accepted one but agree with each other, the encoder has really jumped.
    // Wrong reports would not agree.
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
