// Extends 16-bit encoder readings to full counts, and detects jumps.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace typodont::haptics {

/// Counts of one encoder. Correct if the encoder turns less than half the 16-bit range between two reports; the arms
/// are always slower.
class Encoder {
 public:
  /// Defines that the current reading corresponds to `count`.
  void home(std::int64_t count) noexcept {
    offset_ += count - value();
    slipped_ = false;
  }
  std::int64_t value() const noexcept { return total_ + offset_; }

  /// Result of Encoder::read16() or read32() for a reading.
  enum class Step {
    kGood,
    // The reading is too far from the last accepted reading, and is ignored.
    kRejected,
    // Counts were lost: the encoder's value is wrong until home() is called.
    kSlipped,
  };
  /// `reach`: largest plausible change since the last accepted reading; `nearby`: largest difference at which
  /// two successive readings agree. Counts.
  Step read16(std::int16_t reading, std::int64_t reach, std::int64_t nearby) noexcept {
    // Readings wrap around at 16 bits, so the shorter rotation is taken.
    return take(static_cast<std::int16_t>(static_cast<std::uint16_t>(reading) - static_cast<std::uint16_t>(total_)),
                reach, nearby);
  }
  Step read32(std::int32_t reading, std::int64_t reach, std::int64_t nearby) noexcept {
    return take(reading - total_, reach, nearby);
  }

  // number of successive implausible readings, each near the one before, after which the jump is accepted
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
    // Wrong reports would not agree with each other. If they agree, the encoder has really jumped.
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
