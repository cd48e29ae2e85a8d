#include "engine/render/passes/frame_timer.h"

namespace typodont::render {

FrameTimer FrameTimer::create(gpu::Device& device) {
  FrameTimer timer;
  if (!device.properties.limits.timestampComputeAndGraphics) return timer;
  const VkQueryPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                   .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                   .queryCount = 2 * gpu::FrameRing::kSlots};
  gpu::check(vkCreateQueryPool(device.device, &info, nullptr, &timer.queries), "vkCreateQueryPool");
  return timer;
}

void FrameTimer::destroy(gpu::Device& device) {
  if (queries) vkDestroyQueryPool(device.device, queries, nullptr);
  *this = {};
}

void FrameTimer::begin(VkCommandBuffer commands, int slot) const {
  if (!queries) return;
  const auto first = static_cast<std::uint32_t>(2 * slot);
  vkCmdResetQueryPool(commands, queries, first, 2);
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT, queries, first);
}

void FrameTimer::end(VkCommandBuffer commands, int slot) {
  if (!queries) return;
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries,
                       static_cast<std::uint32_t>(2 * slot + 1));
  timed[static_cast<std::size_t>(slot)] = true;
}

void FrameTimer::read(gpu::Device& device, int slot) {
  const auto i = static_cast<std::size_t>(slot);
  if (!queries || !timed[i]) return;
  std::uint64_t t[2] = {};
  const VkResult result = vkGetQueryPoolResults(device.device, queries, static_cast<std::uint32_t>(2 * slot), 2,
                                                sizeof t, t, sizeof t[0], VK_QUERY_RESULT_64_BIT);
  if (result == VK_SUCCESS)
    ms = static_cast<double>(t[1] - t[0]) * static_cast<double>(device.properties.limits.timestampPeriod) * 1e-6;
  timed[i] = false;
}

}  // namespace typodont::render
