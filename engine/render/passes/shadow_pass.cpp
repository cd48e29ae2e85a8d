#include "engine/render/passes/passes.h"
#include "shaders/shadow_vert.h"

namespace typodont::render {

namespace {

void begin_depth(VkCommandBuffer commands, const gpu::Image& map, const VkRect2D& part) {
  const VkRenderingAttachmentInfo depth{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                        .imageView = map.layer_views[0],
                                        .imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                                        .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                        .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                        .clearValue = {.depthStencil = {1.0f, 0}}};
  const VkRenderingInfo rendering{
      .sType = VK_STRUCTURE_TYPE_RENDERING_INFO, .renderArea = part, .layerCount = 1, .pDepthAttachment = &depth};
  const bool whole = part.extent.width == map.options.size.width && part.extent.height == map.options.size.height;
  gpu::transition(commands, map, whole ? VK_IMAGE_LAYOUT_UNDEFINED : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                  VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                  VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, VK_ACCESS_2_NONE,
                  VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT, VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT);
  vkCmdBeginRendering(commands, &rendering);
}

void end_depth(VkCommandBuffer commands, const gpu::Image& map) {
  vkCmdEndRendering(commands);
  gpu::transition(commands, map, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                  VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT, VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
                  VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT,
                  VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
}

}  // namespace

void ShadowPass::create_map(PassContext& context) {
  const auto side = static_cast<std::uint32_t>(std::max(context.quality.shadow_map, 1));
  map = gpu::Image::create(context.device,
                           {.size = {side, side},
                            .format = kDepthFormat,
                            .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                            .aspect = VK_IMAGE_ASPECT_DEPTH_BIT});
  gpu::run_once(context.device, [&](VkCommandBuffer commands) {
    begin_depth(commands, map, {{0, 0}, map.options.size});
    end_depth(commands, map);
  });
}

gpu::PipelineOptions ShadowPass::options(const PassContext& context) {
  gpu::PipelineOptions o;
  o.vertex_shader = kSpirv_shadow_vert;
  o.layout = context.layout;
  o.bindings = {{0, sizeof(GpuVertex), VK_VERTEX_INPUT_RATE_VERTEX}};
  o.attributes = {{0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(GpuVertex, p)}};
  o.cull = VK_CULL_MODE_NONE;
  o.depth = kDepthFormat;
  o.depth_bias = 1.0f;
  o.depth_bias_slope = 1.5f;
  return o;
}

void ShadowPass::record(PassContext& context, VkCommandBuffer commands, VkDescriptorSet set, BrickStore& bricks,
                        int slot, View view, const glm::mat4& light_from_world, const ShadowMapBox& part,
                        FrameStats& stats) {
  if (!pipeline) pipeline = gpu::get_pipeline(context.device, options(context));
  const VkExtent2D size = map.options.size;
  const glm::vec2 side(static_cast<float>(size.width), static_cast<float>(size.height));
  const glm::ivec2 lo(glm::clamp(glm::floor(part.lo * side) - 1.0f, glm::vec2(0), side)),
      hi(glm::clamp(glm::ceil(part.hi * side) + 1.0f, glm::vec2(0), side));
  if (hi.x <= lo.x || hi.y <= lo.y) return;
  const VkRect2D scissor{{lo.x, lo.y},
                         {static_cast<std::uint32_t>(hi.x - lo.x), static_cast<std::uint32_t>(hi.y - lo.y)}};
  const ShadowMapBox drawn{glm::vec2(lo) / side, glm::vec2(hi) / side};
  const std::vector<DrawGroup> groups = bricks.all(context.device, slot, view, glm::dmat4(light_from_world), drawn);
  begin_depth(commands, map, scissor);
  const VkViewport viewport{0, 0, side.x, side.y, 0, 1};
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetScissor(commands, 0, 1, &scissor);
  vkCmdSetFrontFace(commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, context.layout, 0, 1, &set, 0, nullptr);
  if (!groups.empty())
    bricks.draw(commands, context.layout, bricks.shadow_indirect.buffers[static_cast<std::size_t>(slot)].buffer,
                groups);
  end_depth(commands, map);
  ++stats.passes;
  stats.commands += static_cast<int>(groups.size());
}

void ShadowPass::destroy(gpu::Device& device) {
  map.destroy(device);
}

}  // namespace typodont::render
