// Measures the pictures of a session for --explain: GPU time of each pass, and late frames. Used only by the thread
// that draws.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/base/measure.h"
#include "engine/render/renderer.h"

namespace typodont {

/// Time between two refreshes of a display.
struct RefreshPeriod {
  double seconds = 0;
  const char* source = "";  // where the period comes from, for the user
};

class FrameReport {
 public:
  /// In refresh periods. A frame that begins later than this after the previous frame is late: the display has shown
  /// the previous picture twice.
  static constexpr double kLate = 1.5;
  /// Adds the times of the latest frame that the GPU has finished, once for each frame.
  void add(const render::GpuTimes& times);
  /// Adds a frame that followed another frame without a pause. `interval`: s, time between both.
  void add_interval(double interval, const RefreshPeriod& refresh) {
    refresh_ = refresh;
    ++intervals_;
    late_ += interval > kLate * refresh.seconds;
  }
  /// Late frames in 1,000 frames.
  double late_in_1000() const {
    return intervals_ ? 1000 * static_cast<double>(late_) / static_cast<double>(intervals_) : 0;
  }
  /// The measurements as lines of text for the user; empty if nothing was drawn.
  std::vector<std::string> lines() const;

 private:
  std::uint64_t measured_ = 0;                                // GpuTimes::frames of the frame that was added last
  EvenSample frame_;                                          // ms
  std::array<EvenSample, render::kFrameParts.size()> parts_;  // ms
  RefreshPeriod refresh_;
  std::uint64_t intervals_ = 0, late_ = 0;
};

}  // namespace typodont
