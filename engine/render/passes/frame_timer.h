// How long the GPU takes over a frame, by its own clock.
#pragma once

#include <array>

#include "engine/gpu/resources.h"

namespace typodont::render {

struct FrameTimer {
  VkQueryPool queries = VK_NULL_HANDLE;  // none where the device has no timestamps
  std::array<bool, gpu::FrameRing::kSlots> timed{};
  double ms = 0;  // of the last frame that was read; 0: none

  static FrameTimer create(gpu::Device& device);
  void destroy(gpu::Device& device);
  /// Around a frame's commands.
  void begin(VkCommandBuffer commands, int slot) const;
  void end(VkCommandBuffer commands, int slot);
  /// The slot's last frame is done.
  void read(gpu::Device& device, int slot);
};

}  // namespace typodont::render
