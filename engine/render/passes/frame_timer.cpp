#include "engine/render/passes/frame_timer.h"

namespace typodont::render {

FrameTimer FrameTimer::create(gpu::Device& device) {
  FrameTimer timer;
  if (!device.properties.limits.timestampComputeAndGraphics) return timer;
  const VkQueryPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                   .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                   .queryCount = kMaxQueries * gpu::FrameRing::kSlots};
  gpu::check(vkCreateQueryPool(device.device, &info, nullptr, &timer.queries), "vkCreateQueryPool");
  return timer;
}

void FrameTimer::destroy(gpu::Device& device) {
  if (queries) vkDestroyQueryPool(device.device, queries, nullptr);
  *this = {};
}

void FrameTimer::begin(VkCommandBuffer commands, int of_slot) {
  if (!queries) return;
  slot = of_slot;
  Slot& s = slots[static_cast<std::size_t>(slot)];
  s = {.count = 1, .queries = 1};
  s.marks[0].query = kMaxQueries * static_cast<std::uint32_t>(slot);
  vkCmdResetQueryPool(commands, queries, s.marks[0].query, kMaxQueries);
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT, queries, s.marks[0].query);
}

void FrameTimer::mark(VkCommandBuffer commands, FramePart part, int views) {
  Slot& s = slots[static_cast<std::size_t>(slot)];
  const auto used = static_cast<std::uint32_t>(views);  // Vulkan uses one query per view; the first one has the time
  if (!queries || s.queries + used > kMaxQueries) return;
  s.marks[s.count] = {kMaxQueries * static_cast<std::uint32_t>(slot) + s.queries, part};
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries, s.marks[s.count].query);
  ++s.count;
  s.queries += used;
}

void FrameTimer::end() {
  slots[static_cast<std::size_t>(slot)].timed = queries != VK_NULL_HANDLE;
}

void FrameTimer::read(gpu::Device& device, int of_slot) {
  Slot& s = slots[static_cast<std::size_t>(of_slot)];
  if (!s.timed) return;
  s.timed = false;
  const double tick = 1e-6 * static_cast<double>(device.properties.limits.timestampPeriod);  // ms
  GpuTimes now{.frames = times.frames + 1};
  std::uint64_t last = 0;
  for (std::size_t i = 0; i < s.count; ++i) {
    std::uint64_t t = 0;
    if (vkGetQueryPoolResults(device.device, queries, s.marks[i].query, 1, sizeof t, &t, sizeof t,
                              VK_QUERY_RESULT_64_BIT) != VK_SUCCESS)
      return;
    if (i > 0) {
      const double took = t > last ? tick * static_cast<double>(t - last) : 0;
      now.parts[static_cast<std::size_t>(s.marks[i].part)] += took;
      now.frame += took;
    }
    last = t;
  }
  times = now;
}

}  // namespace typodont::render
