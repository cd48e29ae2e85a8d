// GPU time of a frame, by its clock.
#pragma once

#include <array>

#include "engine/gpu/resources.h"

namespace typodont::render {

struct FrameTimer {
  VkQueryPool queries = VK_NULL_HANDLE;  // null if the device has no timestamps
  std::array<bool, gpu::FrameRing::kSlots> timed{};
  double ms = 0;  // of the last frame read; 0: none yet

  static FrameTimer create(gpu::Device& device);
  void destroy(gpu::Device& device);
  /// Around a frame's commands.
  void begin(VkCommandBuffer commands, int slot) const;
  void end(VkCommandBuffer commands, int slot);
  /// After the slot's frame has finished.
  void read(gpu::Device& device, int slot);
};

}  // namespace typodont::render
