#include "engine/render/passes/passes.h"
#include "shaders/background_frag.h"
#include "shaders/background_vert.h"

namespace typodont::render {

gpu::PipelineOptions BackgroundPass::options(const PassContext& context) {
  gpu::PipelineOptions o = context.scene_pipeline(kSpirv_background_vert, kSpirv_background_frag);
  o.cull = VK_CULL_MODE_NONE;
  o.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
  o.depth_write = false;
  return o;
}

void BackgroundPass::record(PassContext& context, VkCommandBuffer commands, FrameStats& stats) {
  if (!pipeline) pipeline = gpu::get_pipeline(context.device, options(context));
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  vkCmdDraw(commands, 4, 1, 0, 0);
  ++stats.commands;
}

}  // namespace typodont::render
