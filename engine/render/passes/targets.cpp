#include "engine/render/passes/targets.h"

#include <algorithm>
#include <cmath>

namespace typodont::render {

namespace {

constexpr VkPipelineStageFlags2 kOutput = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
constexpr VkPipelineStageFlags2 kResolve = VK_PIPELINE_STAGE_2_RESOLVE_BIT;
constexpr VkPipelineStageFlags2 kTests =
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
constexpr VkAccessFlags2 kDepthUse =
    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT;

/// Begins a pass with all dynamic state set; draws only in `area`.
void begin_pass(VkCommandBuffer commands, const Frame& frame, const VkRenderingAttachmentInfo& color_info,
                const VkRenderingAttachmentInfo& depth_info, std::uint32_t view_mask, const VkExtent2D& extent,
                const VkRect2D& area) {
  const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = area,
                                  .layerCount = 1,
                                  .viewMask = view_mask,
                                  .colorAttachmentCount = 1,
                                  .pColorAttachments = &color_info,
                                  .pDepthAttachment = &depth_info};
  vkCmdBeginRendering(commands, &rendering);
  const VkViewport viewport{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1};
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetScissor(commands, 0, 1, &area);
  // A mirrored view reverses the winding of triangles.
  vkCmdSetFrontFace(commands, frame.eyes[0].flip ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
}

}  // namespace

void Targets::create(const glm::ivec2& frame_size, int views) {
  gpu::Device& device = context_.device;
  const double scale = std::clamp(context_.quality.scale, 0.1, 1.0);
  const VkExtent2D extent{static_cast<std::uint32_t>(std::max(1.0, std::round(frame_size.x * scale))),
                          static_cast<std::uint32_t>(std::max(1.0, std::round(frame_size.y * scale)))};
  const auto layers = static_cast<std::uint32_t>(views);
  context_.samples = std::clamp(context_.quality.samples, 1, std::min(device.max_samples, 4));
  if (context_.samples == 2) context_.samples = 1;  // not all devices support 2 samples; all support 1 and 4
  context_.view_mask = views == 2 && device.multiview ? 3 : 0;
  pictures = gpu::Image::create(device, {.size = extent,
                                         .layers = layers,
                                         .format = kColorFormat,
                                         .alias = kColorBytes,
                                         .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT |
                                                  VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
  // One layer is enough if each eye has its own pass, because both eyes then use the same images in turn.
  const std::uint32_t together = context_.view_mask ? layers : 1;
  if (context_.samples > 1)
    color_ =
        gpu::Image::create(device, {.size = extent,
                                    .layers = together,
                                    .format = kColorFormat,
                                    .samples = context_.samples,
                                    .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT});
  depth_ = gpu::Image::create(device, {.size = extent,
                                       .layers = layered() ? layers : together,
                                       .format = kDepthFormat,
                                       .samples = context_.samples,
                                       .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
                                                (layered() ? VkImageUsageFlags{VK_IMAGE_USAGE_TRANSFER_SRC_BIT} : 0u),
                                       .aspect = VK_IMAGE_ASPECT_DEPTH_BIT});
  if (layered()) {
    scene_ =
        gpu::Image::create(device, {.size = extent,
                                    .layers = layers,
                                    .format = kColorFormat,
                                    .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT});
    scene_depth_ = gpu::Image::create(
        device, {.size = extent,
                 .layers = layers,
                 .format = kDepthFormat,
                 .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                 .aspect = VK_IMAGE_ASPECT_DEPTH_BIT});
  }
  for (int i = 0; keeps_depth && i < (context_.view_mask ? 1 : views); ++i)
    kept_depth.push_back(gpu::Image::create(
        device, {.size = extent,
                 .layers = together,
                 .format = kDepthFormat,
                 .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                 .aspect = VK_IMAGE_ASPECT_DEPTH_BIT}));
}

void Targets::destroy() {
  gpu::Device& device = context_.device;
  pictures.destroy(device);
  color_.destroy(device);
  depth_.destroy(device);
  scene_.destroy(device);
  scene_depth_.destroy(device);
  for (gpu::Image& image : kept_depth) image.destroy(device);
  kept_depth.clear();
}

void Targets::begin(VkCommandBuffer commands, const gpu::Image& target, bool partly) {
  const bool by_command = resolves_by_command();
  const VkImageLayout between =
      &target == &scene_ ? VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  gpu::transition(commands, target, partly ? between : VK_IMAGE_LAYOUT_UNDEFINED,
                  by_command ? VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                  VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE, by_command ? kResolve : kOutput,
                  by_command ? VkAccessFlags2{VK_ACCESS_2_TRANSFER_WRITE_BIT}
                             : VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT);
  if (&target != &scene_) return;
  // A partial redraw has its own depth image, because MaskPass writes the nearest depth to all parts that are kept.
  gpu::transition(commands, partly ? depth_ : scene_depth_, VK_IMAGE_LAYOUT_UNDEFINED,
                  VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE,
                  kTests, kDepthUse);
}

void Targets::begin_scene(VkCommandBuffer commands, const gpu::Image& target, const Frame& frame, int view,
                          const PixelBox& box, bool partly, const glm::vec3& clear) {
  if (context_.samples > 1)
    gpu::transition(commands, color_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                    kOutput | kResolve, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_TRANSFER_READ_BIT, kOutput,
                    VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT);
  const auto e = static_cast<std::size_t>(view);
  const bool layer = &target == &scene_;
  if (!layer)
    gpu::transition(commands, depth_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, kTests,
                    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT, kTests,
                    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT);
  const gpu::Image* kept = keeps_depth && &target == &pictures ? &kept_depth[context_.view_mask ? 0 : e] : nullptr;
  if (kept)
    gpu::transition(commands, *kept, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                    VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE, kTests | kOutput,
                    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
                        VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT);
  const bool kept_direct = kept && context_.samples == 1, kept_resolved = kept && context_.samples > 1;
  const VkExtent2D extent = target.options.size;
  const VkImageView eye_view = context_.view_mask ? target.view : target.layer_views[e];
  const bool in_pass = resolves_in_pass();
  const VkRenderingAttachmentInfo color_info{
      .sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
      .imageView = context_.samples > 1 ? color_.view : eye_view,
      .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
      .resolveMode = in_pass ? VK_RESOLVE_MODE_AVERAGE_BIT : VK_RESOLVE_MODE_NONE,
      .resolveImageView = in_pass ? eye_view : VK_NULL_HANDLE,
      .resolveImageLayout = in_pass ? VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
      .loadOp = !partly                ? VK_ATTACHMENT_LOAD_OP_CLEAR
                : context_.samples > 1 ? VK_ATTACHMENT_LOAD_OP_DONT_CARE
                                       : VK_ATTACHMENT_LOAD_OP_LOAD,
      .storeOp = in_pass ? VK_ATTACHMENT_STORE_OP_DONT_CARE : VK_ATTACHMENT_STORE_OP_STORE,
      .clearValue = {.color = {{clear.r, clear.g, clear.b, frame.background == Background::kClear ? 0.0f : 1.0f}}}};
  const gpu::Image& drawn_depth = layer && !partly ? scene_depth_ : depth_;
  const VkRenderingAttachmentInfo depth_info{
      .sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
      .imageView = kept_direct ? kept->view
                   : layered() ? drawn_depth.layer_views[e]
                               : drawn_depth.view,
      .imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
      .resolveMode = kept_resolved ? VK_RESOLVE_MODE_SAMPLE_ZERO_BIT : VK_RESOLVE_MODE_NONE,
      .resolveImageView = kept_resolved ? kept->view : VK_NULL_HANDLE,
      .resolveImageLayout = kept_resolved ? VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
      .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
      .storeOp = kept_direct || layer ? VK_ATTACHMENT_STORE_OP_STORE : VK_ATTACHMENT_STORE_OP_DONT_CARE,
      .clearValue = {.depthStencil = {1.0f, 0}}};
  begin_pass(commands, frame, color_info, depth_info, context_.view_mask, extent,
             {{box.x, box.y}, {static_cast<std::uint32_t>(box.width), static_cast<std::uint32_t>(box.height)}});
}

void Targets::end_scene(VkCommandBuffer commands, const gpu::Image& target, int view, std::span<const PixelBox> drawn) {
  vkCmdEndRendering(commands);
  if (!resolves_by_command()) return;
  gpu::transition(commands, color_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                  kOutput, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, kResolve, VK_ACCESS_2_TRANSFER_READ_BIT);
  std::vector<VkImageResolve> parts;
  for (const PixelBox& b : drawn)
    parts.push_back({.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                     .srcOffset = {b.x, b.y, 0},
                     .dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, static_cast<std::uint32_t>(view), 1},
                     .dstOffset = {b.x, b.y, 0},
                     .extent = {static_cast<std::uint32_t>(b.width), static_cast<std::uint32_t>(b.height), 1}});
  vkCmdResolveImage(commands, color_.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, target.image,
                    VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, static_cast<std::uint32_t>(parts.size()), parts.data());
}

void Targets::end(VkCommandBuffer commands, const gpu::Image& target) {
  const bool by_command = resolves_by_command();
  gpu::transition(
      commands, target, by_command ? VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
      VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, by_command ? kResolve : kOutput,
      by_command ? VK_ACCESS_2_TRANSFER_WRITE_BIT : VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
      VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_TRANSFER_READ_BIT);
  if (&target != &pictures) return;
  for (const gpu::Image& image : kept_depth)
    gpu::transition(commands, image, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                    kOutput | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
                    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                    VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
}

void Targets::restore_scene(VkCommandBuffer commands, int views, bool partly, const EyeBoxes& drawn,
                            const EyeBoxes& restored) {
  constexpr VkPipelineStageFlags2 kCopy = VK_PIPELINE_STAGE_2_COPY_BIT;
  const auto copy = [&](const gpu::Image& from, const gpu::Image& to, const EyeBoxes& boxes) {
    std::vector<VkImageCopy> parts;
    for (std::uint32_t e = 0; e < static_cast<std::uint32_t>(views); ++e)
      for (const PixelBox& b : boxes[e])
        parts.push_back({.srcSubresource = {from.options.aspect, 0, e, 1},
                         .srcOffset = {b.x, b.y, 0},
                         .dstSubresource = {to.options.aspect, 0, e, 1},
                         .dstOffset = {b.x, b.y, 0},
                         .extent = {static_cast<std::uint32_t>(b.width), static_cast<std::uint32_t>(b.height), 1}});
    if (parts.empty()) return;
    vkCmdCopyImage(commands, from.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.image,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, static_cast<std::uint32_t>(parts.size()), parts.data());
  };
  if (partly) {
    gpu::transition(commands, depth_, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                    kTests, kDepthUse, kCopy, VK_ACCESS_2_TRANSFER_READ_BIT);
    gpu::transition(commands, scene_depth_, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                    VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, kTests, kDepthUse, kCopy, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    copy(depth_, scene_depth_, drawn);
    gpu::transition(commands, scene_depth_, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                    VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, kCopy, VK_ACCESS_2_TRANSFER_WRITE_BIT, kTests, kDepthUse);
  }
  gpu::transition(commands, scene_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                  kOutput, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, kCopy, VK_ACCESS_2_TRANSFER_READ_BIT);
  gpu::transition(commands, pictures, partly ? VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
                  VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE, kCopy,
                  VK_ACCESS_2_TRANSFER_WRITE_BIT);
  copy(scene_, pictures, restored);
  gpu::transition(commands, pictures, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                  kCopy, VK_ACCESS_2_TRANSFER_WRITE_BIT, kOutput,
                  VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT);
}

void Targets::begin_over(VkCommandBuffer commands, const Frame& frame, int view) {
  const auto e = static_cast<std::size_t>(view);
  const VkRenderingAttachmentInfo color_info{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                             .imageView = pictures.layer_views[e],
                                             .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                             .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
                                             .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
  const VkRenderingAttachmentInfo depth_info{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                             .imageView = scene_depth_.layer_views[e],
                                             .imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                                             .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
                                             .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
  const VkExtent2D extent = pictures.options.size;
  begin_pass(commands, frame, color_info, depth_info, 0, extent, {{0, 0}, extent});
}

void Targets::end_over(VkCommandBuffer commands) {
  gpu::transition(commands, pictures, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                  VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, kOutput, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                  VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                  VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_TRANSFER_READ_BIT);
}

}  // namespace typodont::render
