#include <cstring>

#include "engine/render/passes/passes.h"
#include "shaders/hidden_frag.h"
#include "shaders/hidden_vert.h"

namespace typodont::render {

void HiddenPass::set(gpu::Device& device, std::span<const glm::vec3> triangles) {
  corners.destroy(device);
  count = static_cast<std::uint32_t>(triangles.size());
  if (!count) return;
  corners = gpu::Buffer::create(device, triangles.size_bytes(), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  std::memcpy(corners.memory.mapped, triangles.data(), triangles.size_bytes());
}

gpu::PipelineOptions HiddenPass::options(const PassContext& context) {
  gpu::PipelineOptions o = context.scene_pipeline(kSpirv_hidden_vert, kSpirv_hidden_frag);
  o.bindings = {{0, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX}};
  o.attributes = {{0, VK_FORMAT_R32G32B32_SFLOAT, 0}};
  o.cull = VK_CULL_MODE_NONE;
  return o;
}

void HiddenPass::record(PassContext& context, VkCommandBuffer commands, FrameStats& stats) {
  if (!count) return;
  if (!pipeline) pipeline = gpu::get_pipeline(context.device, options(context));
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  draw_vertices(commands, corners.buffer, count, stats);
}

void HiddenPass::destroy(gpu::Device& device) {
  corners.destroy(device);
}

}  // namespace typodont::render
