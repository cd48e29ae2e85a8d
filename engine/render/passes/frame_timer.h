// Measures the parts of a frame with the GPU's clock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/gpu/resources.h"
#include "engine/render/renderer.h"

namespace typodont::render {

struct FrameTimer {
  static constexpr std::uint32_t kMaxQueries = 64;  // largest number of queries per frame in flight
  struct Mark {
    std::uint32_t query = 0;
    FramePart part{};  // the part of the frame that this mark ends
  };
  struct Slot {
    std::array<Mark, kMaxQueries> marks;
    std::size_t count = 0;
    std::uint32_t queries = 0;  // number of queries used
    bool timed = false;
  };
  VkQueryPool queries = VK_NULL_HANDLE;  // null if the device has no timestamps
  std::array<Slot, gpu::FrameRing::kSlots> slots;
  int slot = 0;    // slot of the frame that is being recorded
  GpuTimes times;  // times of the last frame that was read; 0: none yet

  static FrameTimer create(gpu::Device& device);
  void destroy(gpu::Device& device);
  /// Call at the begin of a frame's commands.
  void begin(VkCommandBuffer commands, int of_slot);
  /// Ends a part, which began at the last mark. `views`: number of views of the current pass.
  void mark(VkCommandBuffer commands, FramePart part, int views = 1);
  /// Call at the end of a frame's commands.
  void end();
  /// Call after the frame in this slot has finished.
  void read(gpu::Device& device, int of_slot);
};

}  // namespace typodont::render
