#include "engine/app/picture/frame_report.h"

#include <fmt/format.h>

namespace typodont {

void FrameReport::add(const render::GpuTimes& times) {
  if (times.frames == measured_) return;
  measured_ = times.frames;
  frame_.add(times.frame);
  for (std::size_t i = 0; i < parts_.size(); ++i) parts_[i].add(times.parts[i]);
}

std::vector<std::string> FrameReport::lines() const {
  std::vector<std::string> lines;
  if (intervals_ > 0)
    lines.push_back(fmt::format("late frames: {:.1f} of 1,000, more than {:g} × {:.1f} ms after the previous one ({})",
                                late_in_1000(), kLate, 1e3 * refresh_.seconds, refresh_.source));
  if (measured_ == 0) return lines;
  const auto add = [&](const char* name, const EvenSample& ms) {
    lines.push_back(
        fmt::format("GPU time, {}: median {:.2f} ms, 99 % {:.2f} ms", name, ms.quantile(0.5), ms.quantile(0.99)));
  };
  add("whole frame", frame_);
  for (std::size_t i = 0; i < parts_.size(); ++i) add(render::kFrameParts[i], parts_[i]);
  return lines;
}

}  // namespace typodont
