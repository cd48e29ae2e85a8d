// Measures a frame's GPU time with the GPU's clock.
#pragma once

#include <array>

#include "engine/gpu/resources.h"

namespace typodont::render {

struct FrameTimer {
  VkQueryPool queries = VK_NULL_HANDLE;  // null if the device has no timestamps
  std::array<bool, gpu::FrameRing::kSlots> timed{};
  double ms = 0;  // ms, time of the last frame that was read; 0: none yet

  static FrameTimer create(gpu::Device& device);
  void destroy(gpu::Device& device);
  /// Call at begin and end of a frame's commands.
  void begin(VkCommandBuffer commands, int slot) const;
  void end(VkCommandBuffer commands, int slot);
  /// Call after the frame in this slot has finished.
  void read(gpu::Device& device, int slot);
};

}  // namespace typodont::render
