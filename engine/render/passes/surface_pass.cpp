#include "engine/render/passes/passes.h"
#include "shaders/surface_frag.h"
#include "shaders/surface_vert.h"

namespace typodont::render {

void SurfacePass::record(PassContext& context, VkCommandBuffer commands, BrickStore& bricks, int slot,
                         std::span<const DrawGroup> groups, FrameStats& stats) {
  if (groups.empty()) return;
  if (!pipeline) {
    gpu::PipelineOptions o = context.scene_pipeline(kSpirv_surface_vert, kSpirv_surface_frag);
    o.bindings = {{0, sizeof(GpuVertex), VK_VERTEX_INPUT_RATE_VERTEX}};
    o.attributes = {{0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(GpuVertex, p)},
                    {0, VK_FORMAT_R16G16B16A16_SNORM, offsetof(GpuVertex, n)},
                    {0, VK_FORMAT_R8G8B8A8_UINT, offsetof(GpuVertex, tissue)}};
    pipeline = gpu::create_pipeline(context.device, o);
  }
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  bricks.draw(commands, context.layout, bricks.indirect.buffers[static_cast<std::size_t>(slot)].buffer, groups);
  stats.commands += static_cast<int>(groups.size());
}

}  // namespace typodont::render
