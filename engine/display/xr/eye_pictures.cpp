#include "engine/display/xr/eye_pictures.h"

#include <algorithm>

#include "engine/base/error.h"

namespace typodont::display::xr {

namespace {

constexpr VkFormat kPictures = VK_FORMAT_R8G8B8A8_SRGB;  // format in which the renderer draws

void open_for_copy(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect) {
  gpu::transition(commands, image, aspect, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                  VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE, VK_PIPELINE_STAGE_2_TRANSFER_BIT,
                  VK_ACCESS_2_TRANSFER_WRITE_BIT);
}

}  // namespace

EyePictures::EyePictures(Api& api, XrSession session, const std::string& headset, ivec2 size, bool depth)
    : api_(api), session_(session), size_(size) {
  const auto offered =
      api_.list<std::int64_t>("xrEnumerateSwapchainFormats", api_.EnumerateSwapchainFormats, 0, session_);
  const auto offers = [&](VkFormat format) {
    return std::find(offered.begin(), offered.end(), format) != offered.end();
  };
  // Selects the first format of this list that the runtime offers. The first one needs no conversion. The last ones are
  // 8-bit formats without sRGB, whose values the runtime interprets as linear light.
  VkFormat format = VK_FORMAT_UNDEFINED;
  for (const VkFormat f : {kPictures, VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R8G8B8A8_UNORM,
                           VK_FORMAT_B8G8R8A8_UNORM})
    if (format == VK_FORMAT_UNDEFINED && offers(f)) format = f;
  if (format == VK_FORMAT_UNDEFINED)
    throw Error("OpenXR", headset, "no swapchain format known here", "an 8-bit sRGB one");
  color_ = create(format, XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT);
  wants_depth_ = depth && api_.has(XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME) && offers(VK_FORMAT_D32_SFLOAT);
  if (!wants_depth_) return;
  try {
    depth_ = create(VK_FORMAT_D32_SFLOAT, XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
  } catch (const RunFailure&) {  // the runtime accepts no depth
    wants_depth_ = false;
  }
}

EyePictures::~EyePictures() {
  for (const Swapchain* chain : {&color_, &depth_})
    if (chain->handle) api_.attempt("xrDestroySwapchain", api_.DestroySwapchain, chain->handle);
}

EyePictures::Swapchain EyePictures::create(VkFormat format, XrSwapchainUsageFlags usage) {
  Swapchain chain;
  chain.format = format;
  const XrSwapchainCreateInfo info{XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                   nullptr,
                                   0,
                                   usage | XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT,
                                   format,
                                   1,
                                   static_cast<std::uint32_t>(size_.x),
                                   static_cast<std::uint32_t>(size_.y),
                                   1,
                                   2,
                                   1};
  api_.call("xrCreateSwapchain", api_.CreateSwapchain, session_, &info, &chain.handle);
  std::uint32_t count = 0;
  api_.call("xrEnumerateSwapchainImages", api_.EnumerateSwapchainImages, chain.handle, 0u, &count,
            static_cast<XrSwapchainImageBaseHeader*>(nullptr));
  std::vector<XrSwapchainImageVulkanKHR> images(count, {XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR, nullptr, VK_NULL_HANDLE});
  api_.call("xrEnumerateSwapchainImages", api_.EnumerateSwapchainImages, chain.handle, count, &count,
            reinterpret_cast<XrSwapchainImageBaseHeader*>(images.data()));
  for (const XrSwapchainImageVulkanKHR& image : images) chain.images.push_back(image.image);
  return chain;
}

void EyePictures::record(VkCommandBuffer commands, const gpu::Image& pictures, const std::array<Hmd::Depth, 2>& depth) {
  const VkExtent2D size = pictures.options.size;
  drawn_size_ = {static_cast<std::int32_t>(std::min<std::uint32_t>(size.width, static_cast<std::uint32_t>(size_.x))),
                 static_cast<std::int32_t>(std::min<std::uint32_t>(size.height, static_cast<std::uint32_t>(size_.y)))};
  const VkExtent3D extent{static_cast<std::uint32_t>(drawn_size_.width), static_cast<std::uint32_t>(drawn_size_.height),
                          1};
  const VkImage color = acquire(color_);
  gpu::transition(commands, pictures, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                  VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT, VK_PIPELINE_STAGE_2_TRANSFER_BIT,
                  VK_ACCESS_2_TRANSFER_READ_BIT);
  open_for_copy(commands, color, VK_IMAGE_ASPECT_COLOR_BIT);
  for (std::uint32_t eye = 0; eye < 2; ++eye) {
    const VkImageSubresourceLayers from{VK_IMAGE_ASPECT_COLOR_BIT, 0, std::min(eye, pictures.options.layers - 1), 1},
        to{VK_IMAGE_ASPECT_COLOR_BIT, 0, eye, 1};
    if (color_.format == kPictures) {
      const VkImageCopy copy{.srcSubresource = from, .dstSubresource = to, .extent = extent};
      vkCmdCopyImage(commands, pictures.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, color,
                     VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    } else {  // pictures in this format must be converted to another encoding
      const VkOffset3D end{drawn_size_.width, drawn_size_.height, 1};
      const VkImageBlit blit{from, {{0, 0, 0}, end}, to, {{0, 0, 0}, end}};
      vkCmdBlitImage(commands, pictures.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, color,
                     VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit, VK_FILTER_NEAREST);
    }
  }
  gpu::transition(commands, color, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                  VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_PIPELINE_STAGE_2_TRANSFER_BIT,
                  VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_READ_BIT);
  gpu::transition(commands, pictures, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                  VK_PIPELINE_STAGE_2_TRANSFER_BIT, VK_ACCESS_2_NONE, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                  VK_ACCESS_2_MEMORY_READ_BIT);
  has_depth_ = wants_depth_ && depth[0].image && depth[1].image;
  if (!has_depth_) return;
  const VkImage target = acquire(depth_);
  open_for_copy(commands, target, VK_IMAGE_ASPECT_DEPTH_BIT);
  for (std::uint32_t eye = 0; eye < 2; ++eye) {
    const VkImageCopy copy{.srcSubresource = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, depth[eye].layer, 1},
                           .dstSubresource = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, eye, 1},
                           .extent = extent};
    vkCmdCopyImage(commands, depth[eye].image->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, target,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
  }
  gpu::transition(commands, target, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                  VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL, VK_PIPELINE_STAGE_2_TRANSFER_BIT,
                  VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_READ_BIT);
}

void EyePictures::release() {
  release(color_);
  release(depth_);
}

XrSwapchainSubImage EyePictures::color(std::uint32_t eye) const {
  return {color_.handle, {{0, 0}, drawn_size_}, eye};
}

XrSwapchainSubImage EyePictures::depth(std::uint32_t eye) const {
  return {depth_.handle, {{0, 0}, drawn_size_}, eye};
}

VkImage EyePictures::acquire(Swapchain& chain) {
  std::uint32_t index = 0;
  const XrSwapchainImageAcquireInfo acquire_info{XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO};
  api_.call("xrAcquireSwapchainImage", api_.AcquireSwapchainImage, chain.handle, &acquire_info, &index);
  const XrSwapchainImageWaitInfo wait_info{XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, nullptr, XR_INFINITE_DURATION};
  api_.call("xrWaitSwapchainImage", api_.WaitSwapchainImage, chain.handle, &wait_info);
  chain.held = true;
  return chain.images.at(index);
}

void EyePictures::release(Swapchain& chain) {
  if (!chain.held) return;
  const XrSwapchainImageReleaseInfo info{XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO};
  api_.call("xrReleaseSwapchainImage", api_.ReleaseSwapchainImage, chain.handle, &info);
  chain.held = false;
}

}  // namespace typodont::display::xr
