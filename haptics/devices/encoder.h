// Incremental encoders sent as 16-bit counts: made whole again, and watched for jumps.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace typodont::haptics {

/// One encoder. Good while it turns less than half its range between two reports, which the arms here cannot exceed in
/// their whole workspace.
class Encoder {
 public:
  /// Sets the count that the present reading stands for.
  void home(std::int64_t count) noexcept {
    offset_ += count - value();
    slipped_ = false;
  }
  std::int64_t value() const noexcept { return total_ + offset_; }

  /// How a reading was taken.
  enum class Step {
    kGood,
    kRejected,  // too far from the last one: a broken report, the count stays
    kSlipped,   // it stays too far: counts were lost, and the position is wrong until the arm is homed
  };
  /// `reach`: the most counts it can have turned since the last good reading; `nearby`: between two readings.
  Step read16(std::int16_t reading, std::int64_t reach, std::int64_t nearby) noexcept {
    // int16 difference of int16 readings: the shorter way round
    return take(static_cast<std::int16_t>(static_cast<std::uint16_t>(reading) - static_cast<std::uint16_t>(total_)),
                reach, nearby);
  }
  Step read32(std::int32_t reading, std::int64_t reach, std::int64_t nearby) noexcept {
    return take(reading - total_, reach, nearby);
  }

  static constexpr int kBelieved = 8;  // far readings in a row that agree, before they are believed

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
    // Readings that agree with one another but not with us: the encoder has jumped, not the report. Garbage does not
    // agree.
    rejected_ = rejected_ > 0 && std::llabs(step - rejected_step_) <= nearby ? rejected_ + 1 : 1;
    rejected_step_ = step;
    if (rejected_ < kBelieved) return Step::kRejected;
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
