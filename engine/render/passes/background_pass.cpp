#include "engine/render/passes/passes.h"
#include "shaders/background_frag.h"
#include "shaders/background_vert.h"

namespace typodont::render {

void BackgroundPass::record(PassContext& context, VkCommandBuffer commands, FrameStats& stats) {
  if (!pipeline) {
    gpu::PipelineOptions o = context.scene_pipeline(kSpirv_background_vert, kSpirv_background_frag);
    o.cull = VK_CULL_MODE_NONE;
    o.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
    o.depth_write = false;
    pipeline = gpu::get_pipeline(context.device, o);
  }
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  vkCmdDraw(commands, 4, 1, 0, 0);
  ++stats.commands;
}

}  // namespace typodont::render
