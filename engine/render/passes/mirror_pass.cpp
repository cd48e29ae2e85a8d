#include "engine/render/mirror.h"
#include "engine/render/passes/passes.h"
#include "shaders/mirror_frag.h"
#include "shaders/mirror_vert.h"

namespace typodont::render {

void MirrorPass::prepare(gpu::Device& device, double wanted) {
  if (body.mesh.index_count && diameter == wanted) return;
  diameter = wanted;
  vkDeviceWaitIdle(device.device);
  body.set(device, make_mirror_body(wanted));
}

void MirrorPass::create_picture(PassContext& context, VkExtent2D size, std::uint32_t layers) {
  if (picture.image) return;
  picture =
      gpu::Image::create(context.device, {.size = size,
                                          .layers = layers,
                                          .format = kColorFormat,
                                          .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT |
                                                   VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
}

gpu::PipelineOptions MirrorPass::options(const PassContext& context) {
  gpu::PipelineOptions o = context.scene_pipeline(kSpirv_mirror_vert, kSpirv_mirror_frag);
  o.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
  return o;
}

void MirrorPass::record_glass(PassContext& context, VkCommandBuffer commands, const MouthMirror& mirror,
                              FrameStats& stats) {
  if (!pipeline) pipeline = gpu::get_pipeline(context.device, options(context));
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  push(commands, context.layout, mirror.X_WM);
  vkCmdDraw(commands, kGlassCorners, 1, 0, 0);
  ++stats.commands;
}

void MirrorPass::destroy_pictures(gpu::Device& device) {
  pipeline = VK_NULL_HANDLE;
  picture.destroy(device);
}

void MirrorPass::destroy(gpu::Device& device) {
  destroy_pictures(device);
  body.mesh.destroy(device);
}

}  // namespace typodont::render
