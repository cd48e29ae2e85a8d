// Measures the GPU time of a frame with the GPU's clock.
#pragma once

#include <array>

#include "engine/gpu/resources.h"

namespace typodont::render {

struct FrameTimer {
  VkQueryPool queries = VK_NULL_HANDLE;  // null if the device has no timestamps
  std::array<bool, gpu::FrameRing::kSlots> timed{};
  double ms = 0;  // ms, GPU time of the last frame whose time was read; 0: no time was read yet

  static FrameTimer create(gpu::Device& device);
  void destroy(gpu::Device& device);
  /// Call at the beginning and at the end of a frame's commands.
  void begin(VkCommandBuffer commands, int slot) const;
  void end(VkCommandBuffer commands, int slot);
  /// Reads the GPU time of the last frame with this slot (frame in flight). Call it after this frame has finished.
  void read(gpu::Device& device, int slot);
};

}  // namespace typodont::render
