#include <cstring>

#include "engine/render/passes/passes.h"

namespace typodont::render {

void MaskPass::prepare(PassContext& context, int slot, const glm::ivec2& size, const EyeBoxes& kept) {
  std::vector<glm::vec3> out;
  for (std::size_t e = 0; e < kept.size(); ++e) {
    first[e] = static_cast<std::uint32_t>(out.size());
    for (const PixelBox& b : kept[e]) {
      const glm::vec2 lo = 2.0f * glm::vec2(b.x, b.y) / glm::vec2(size) - 1.0f,
                      hi = 2.0f * glm::vec2(b.x + b.width, b.y + b.height) / glm::vec2(size) - 1.0f;
      for (const auto& [x, y] :
           {std::pair{lo.x, lo.y}, {hi.x, lo.y}, {hi.x, hi.y}, {lo.x, lo.y}, {hi.x, hi.y}, {lo.x, hi.y}})
        out.push_back({x, y, static_cast<float>(e)});
    }
    count[e] = static_cast<std::uint32_t>(out.size()) - first[e];
  }
  if (out.empty()) return;
  gpu::Buffer& buffer =
      corners.at_least(context.device, slot, out.size() * sizeof(glm::vec3), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  std::memcpy(buffer.memory.mapped, out.data(), out.size() * sizeof(glm::vec3));
}

gpu::PipelineOptions MaskPass::options(const PassContext& context) {
  gpu::PipelineOptions o = HiddenPass::options(context);
  o.depth_compare = VK_COMPARE_OP_ALWAYS;
  o.color_write = false;
  return o;
}

void MaskPass::record(PassContext& context, VkCommandBuffer commands, int slot, int view, FrameStats& stats) {
  const auto e = static_cast<std::size_t>(view);
  if (!count[e]) return;
  if (!pipeline) pipeline = gpu::get_pipeline(context.device, options(context));
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  draw_vertices(commands, corners.buffers[static_cast<std::size_t>(slot)].buffer, count[e], stats, first[e]);
}

void MaskPass::destroy(gpu::Device& device) {
  corners.destroy(device);
}

}  // namespace typodont::render
