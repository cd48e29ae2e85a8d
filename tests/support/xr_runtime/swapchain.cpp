// Swapchains as Vulkan images on the program's device, and export of their content as PNG.
#include <png.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "tests/support/xr_runtime/runtime.h"

namespace typodont::test::xr {

namespace {

const std::map<std::string, VkFormat>& format_names() {
  static const std::map<std::string, VkFormat> names{{"R8G8B8A8_SRGB", VK_FORMAT_R8G8B8A8_SRGB},
                                                     {"B8G8R8A8_SRGB", VK_FORMAT_B8G8R8A8_SRGB},
                                                     {"R8G8B8A8_UNORM", VK_FORMAT_R8G8B8A8_UNORM},
                                                     {"B8G8R8A8_UNORM", VK_FORMAT_B8G8R8A8_UNORM},
                                                     {"R16G16B16A16_SFLOAT", VK_FORMAT_R16G16B16A16_SFLOAT},
                                                     {"D32_SFLOAT", VK_FORMAT_D32_SFLOAT},
                                                     {"D16_UNORM", VK_FORMAT_D16_UNORM}};
  return names;
}

bool is_depth(VkFormat format) {
  return format == VK_FORMAT_D32_SFLOAT || format == VK_FORMAT_D16_UNORM;
}

VkImageLayout layout_of(const Swapchain& s) {
  return s.depth ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
}
VkImageAspectFlags aspect_of(const Swapchain& s) {
  return s.depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

std::uint32_t memory_type(VkPhysicalDevice physical, std::uint32_t bits, VkMemoryPropertyFlags wanted) {
  VkPhysicalDeviceMemoryProperties properties;
  vkGetPhysicalDeviceMemoryProperties(physical, &properties);
  for (std::uint32_t i = 0; i < properties.memoryTypeCount; ++i)
    if ((bits & (1u << i)) && (properties.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
  return 0;
}

void barrier(VkCommandBuffer commands, const Swapchain& s, VkImage image, VkImageLayout from, VkImageLayout to) {
  const VkImageMemoryBarrier b{
      .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
      .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
      .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
      .oldLayout = from,
      .newLayout = to,
      .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .image = image,
      .subresourceRange = {aspect_of(s), 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS}};
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr,
                       0, nullptr, 1, &b);
}

template <class Record>
void run_once(Session& session, Record record) {
  const VkCommandBufferAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                             .commandPool = session.pool,
                                             .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                             .commandBufferCount = 1};
  VkCommandBuffer commands = VK_NULL_HANDLE;
  vkAllocateCommandBuffers(session.device, &allocate, &commands);
  const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                       .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  vkBeginCommandBuffer(commands, &begin);
  record(commands);
  vkEndCommandBuffer(commands);
  const VkSubmitInfo submit{
      .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
  vkQueueSubmit(session.queue, 1, &submit, VK_NULL_HANDLE);
  vkQueueWaitIdle(session.queue);
  vkFreeCommandBuffers(session.device, session.pool, 1, &commands);
}

Swapchain* find(XrSwapchain handle, const char* call) {
  const auto found = runtime().swapchains.find(handle);
  if (found != runtime().swapchains.end()) return found->second.get();
  violation(XR_ERROR_HANDLE_INVALID, "{}: no such swapchain", call);
  return nullptr;
}

XRAPI_ATTR XrResult XRAPI_CALL formats(XrSession session, std::uint32_t capacity, std::uint32_t* count,
                                       std::int64_t* out) {
  if (const XrResult refused = enter_session("xrEnumerateSwapchainFormats", session)) return refused;
  std::vector<std::int64_t> all;
  for (const std::string& name : runtime().script.formats) all.push_back(format_names().at(name));
  return give(all, capacity, count, out, "xrEnumerateSwapchainFormats");
}

XRAPI_ATTR XrResult XRAPI_CALL create(XrSession session, const XrSwapchainCreateInfo* info, XrSwapchain* swapchain) {
  if (const XrResult refused = enter_session("xrCreateSwapchain", session)) return refused;
  Runtime& r = runtime();
  Session& s = *r.session;
  if (!typed(info, XR_TYPE_SWAPCHAIN_CREATE_INFO, "xrCreateSwapchain", "info")) return XR_ERROR_VALIDATION_FAILURE;
  const auto format = static_cast<VkFormat>(info->format);
  const auto& names = r.script.formats;
  if (std::none_of(names.begin(), names.end(), [&](const std::string& n) { return format_names().at(n) == format; }))
    return violation(XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED, "xrCreateSwapchain: format {} is not offered",
                     info->format);
  if (info->width == 0 || info->height == 0 || info->width > 4096 || info->height > 4096 || info->faceCount != 1 ||
      info->mipCount != 1 || info->sampleCount != 1 || info->arraySize < 1 || info->arraySize > 2)
    return violation(XR_ERROR_VALIDATION_FAILURE, "xrCreateSwapchain: {}×{}, {} layers, {} samples", info->width,
                     info->height, info->arraySize, info->sampleCount);
  auto made = std::make_unique<Swapchain>();
  made->info = *info;
  made->depth = is_depth(format);
  VkImageUsageFlags usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  const auto want = [&](XrSwapchainUsageFlags flag, VkImageUsageFlags vk) {
    if (info->usageFlags & flag) usage |= vk;
  };
  want(XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
  want(XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
  want(XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT, VK_IMAGE_USAGE_TRANSFER_DST_BIT);
  want(XR_SWAPCHAIN_USAGE_SAMPLED_BIT, VK_IMAGE_USAGE_SAMPLED_BIT);
  if (made->depth && (info->usageFlags & XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT))
    return violation(XR_ERROR_FEATURE_UNSUPPORTED, "xrCreateSwapchain: depth as colour attachment");
  for (std::int64_t i = 0; i < r.script.images; ++i) {
    const VkImageCreateInfo image_info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                       .imageType = VK_IMAGE_TYPE_2D,
                                       .format = format,
                                       .extent = {info->width, info->height, 1},
                                       .mipLevels = 1,
                                       .arrayLayers = info->arraySize,
                                       .samples = VK_SAMPLE_COUNT_1_BIT,
                                       .tiling = VK_IMAGE_TILING_OPTIMAL,
                                       .usage = usage};
    VkImage image = VK_NULL_HANDLE;
    if (vkCreateImage(s.device, &image_info, nullptr, &image) != VK_SUCCESS) return XR_ERROR_RUNTIME_FAILURE;
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(s.device, image, &needs);
    const VkMemoryAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                        .allocationSize = needs.size,
                                        .memoryTypeIndex = memory_type(s.physical, needs.memoryTypeBits, 0)};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    if (vkAllocateMemory(s.device, &allocate, nullptr, &memory) != VK_SUCCESS) return XR_ERROR_OUT_OF_MEMORY;
    vkBindImageMemory(s.device, image, memory, 0);
    made->images.push_back(image);
    made->memory.push_back(memory);
  }
  run_once(s, [&](VkCommandBuffer commands) {
    for (VkImage image : made->images) barrier(commands, *made, image, VK_IMAGE_LAYOUT_UNDEFINED, layout_of(*made));
  });
  log("swapchain {}×{} of {} layers, format {}", info->width, info->height, info->arraySize, info->format);
  *swapchain = r.handle<XrSwapchain>();
  r.swapchains.emplace(*swapchain, std::move(made));
  return XR_SUCCESS;
}

void destroy_images(Swapchain& s) {
  const VkDevice device = runtime().session->device;
  vkDeviceWaitIdle(device);
  for (VkImage image : s.images) vkDestroyImage(device, image, nullptr);
  for (VkDeviceMemory memory : s.memory) vkFreeMemory(device, memory, nullptr);
}

XRAPI_ATTR XrResult XRAPI_CALL destroy(XrSwapchain handle) {
  if (const XrResult refused = enter("xrDestroySwapchain")) return refused;
  Swapchain* s = find(handle, "xrDestroySwapchain");
  if (!s) return XR_ERROR_HANDLE_INVALID;
  destroy_images(*s);
  runtime().swapchains.erase(handle);
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL images(XrSwapchain handle, std::uint32_t capacity, std::uint32_t* count,
                                      XrSwapchainImageBaseHeader* out) {
  if (const XrResult refused = enter("xrEnumerateSwapchainImages")) return refused;
  Swapchain* s = find(handle, "xrEnumerateSwapchainImages");
  if (!s) return XR_ERROR_HANDLE_INVALID;
  *count = static_cast<std::uint32_t>(s->images.size());
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < *count) return XR_ERROR_SIZE_INSUFFICIENT;
  auto* vulkan = reinterpret_cast<XrSwapchainImageVulkanKHR*>(out);
  for (std::size_t i = 0; i < s->images.size(); ++i) {
    if (!typed(vulkan + i, XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR, "xrEnumerateSwapchainImages", "an image"))
      return XR_ERROR_VALIDATION_FAILURE;
    vulkan[i].image = s->images[i];
  }
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL acquire(XrSwapchain handle, const XrSwapchainImageAcquireInfo*, std::uint32_t* index) {
  if (const XrResult refused = enter("xrAcquireSwapchainImage")) return refused;
  Swapchain* s = find(handle, "xrAcquireSwapchainImage");
  if (!s) return XR_ERROR_HANDLE_INVALID;
  if (runtime().session->lost) return XR_ERROR_SESSION_LOST;
  if (s->acquired.size() >= s->images.size())
    return violation(XR_ERROR_CALL_ORDER_INVALID, "xrAcquireSwapchainImage: all images are held");
  *index = s->next;
  s->next = (s->next + 1) % static_cast<std::uint32_t>(s->images.size());
  s->acquired.push_back(*index);
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL wait(XrSwapchain handle, const XrSwapchainImageWaitInfo* info) {
  if (const XrResult refused = enter("xrWaitSwapchainImage")) return refused;
  Swapchain* s = find(handle, "xrWaitSwapchainImage");
  if (!s) return XR_ERROR_HANDLE_INVALID;
  if (!typed(info, XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, "xrWaitSwapchainImage", "info"))
    return XR_ERROR_VALIDATION_FAILURE;
  if (runtime().session->lost) return XR_ERROR_SESSION_LOST;
  if (s->acquired.empty() || s->waited)
    return violation(XR_ERROR_CALL_ORDER_INVALID, "xrWaitSwapchainImage: nothing to wait for");
  s->waited = true;
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL release(XrSwapchain handle, const XrSwapchainImageReleaseInfo*) {
  if (const XrResult refused = enter("xrReleaseSwapchainImage")) return refused;
  Swapchain* s = find(handle, "xrReleaseSwapchainImage");
  if (!s) return XR_ERROR_HANDLE_INVALID;
  if (runtime().session->lost) return XR_ERROR_SESSION_LOST;
  if (!s->waited) return violation(XR_ERROR_CALL_ORDER_INVALID, "xrReleaseSwapchainImage: not waited for");
  s->last_released = static_cast<int>(s->acquired.front());
  s->acquired.pop_front();
  s->waited = false;
  s->released_in = runtime().session->begun;
  return XR_SUCCESS;
}

/// Reads four bytes per pixel as stored in memory.
std::vector<std::uint8_t> read(const Swapchain& s, std::uint32_t layer, const XrRect2Di& rect) {
  Session& session = *runtime().session;
  const VkDeviceSize bytes =
      VkDeviceSize{4} * static_cast<VkDeviceSize>(rect.extent.width) * static_cast<VkDeviceSize>(rect.extent.height);
  const VkBufferCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = bytes, .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
  VkBuffer buffer = VK_NULL_HANDLE;
  vkCreateBuffer(session.device, &info, nullptr, &buffer);
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(session.device, buffer, &needs);
  const VkMemoryAllocateInfo allocate{
      .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
      .allocationSize = needs.size,
      .memoryTypeIndex = memory_type(session.physical, needs.memoryTypeBits,
                                     VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT)};
  VkDeviceMemory memory = VK_NULL_HANDLE;
  vkAllocateMemory(session.device, &allocate, nullptr, &memory);
  vkBindBufferMemory(session.device, buffer, memory, 0);
  const VkImage image = s.images[static_cast<std::size_t>(s.last_released)];
  run_once(session, [&](VkCommandBuffer commands) {
    barrier(commands, s, image, layout_of(s), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    const VkBufferImageCopy copy{.imageSubresource = {aspect_of(s), 0, layer, 1},
                                 .imageOffset = {rect.offset.x, rect.offset.y, 0},
                                 .imageExtent = {static_cast<std::uint32_t>(rect.extent.width),
                                                 static_cast<std::uint32_t>(rect.extent.height), 1}};
    vkCmdCopyImageToBuffer(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer, 1, &copy);
    barrier(commands, s, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, layout_of(s));
  });
  std::vector<std::uint8_t> out(bytes);
  void* mapped = nullptr;
  vkMapMemory(session.device, memory, 0, VK_WHOLE_SIZE, 0, &mapped);
  std::memcpy(out.data(), mapped, bytes);
  vkDestroyBuffer(session.device, buffer, nullptr);
  vkFreeMemory(session.device, memory, nullptr);
  return out;
}

}  // namespace

bool check_sub_image(const XrSwapchainSubImage& image, bool depth, const char* what) {
  const auto found = runtime().swapchains.find(image.swapchain);
  if (found == runtime().swapchains.end()) {
    violation(XR_SUCCESS, "{}: no such swapchain", what);
    return false;
  }
  const Swapchain& s = *found->second;
  const XrRect2Di& r = image.imageRect;
  if (s.last_released < 0) violation(XR_SUCCESS, "{}: its swapchain was never released", what);
  if (s.released_in != runtime().session->begun) violation(XR_SUCCESS, "{}: not drawn in this frame", what);
  if (s.depth != depth) violation(XR_SUCCESS, "{}: of the wrong kind", what);
  if (image.imageArrayIndex >= s.info.arraySize) violation(XR_SUCCESS, "{}: layer {}", what, image.imageArrayIndex);
  const bool inside = r.offset.x >= 0 && r.offset.y >= 0 && r.extent.width > 0 && r.extent.height > 0 &&
                      r.offset.x + r.extent.width <= static_cast<int>(s.info.width) &&
                      r.offset.y + r.extent.height <= static_cast<int>(s.info.height);
  if (!inside) violation(XR_SUCCESS, "{}: rectangle", what);
  return s.last_released >= 0 && s.depth == depth && image.imageArrayIndex < s.info.arraySize && inside;
}

void capture(std::uint64_t frame, const XrCompositionLayerProjection& layer) {
  Runtime& r = runtime();
  const auto& frames = r.script.capture;
  if (std::find(frames.begin(), frames.end(), static_cast<std::int64_t>(frame)) == frames.end()) return;
  vkDeviceWaitIdle(r.session->device);
  for (std::uint32_t i = 0; i < 2; ++i) {
    const XrCompositionLayerProjectionView& view = layer.views[i];
    const Swapchain& s = *r.swapchains.at(view.subImage.swapchain);
    const XrRect2Di& rect = view.subImage.imageRect;
    const std::string name = fmt::format("{}/frame{}_{}", r.script.out, frame, i ? "right" : "left");
    std::vector<std::uint8_t> pixels = read(s, view.subImage.imageArrayIndex, rect);
    const bool swapped = s.info.format == VK_FORMAT_B8G8R8A8_SRGB || s.info.format == VK_FORMAT_B8G8R8A8_UNORM;
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(rect.extent.width);
    png.height = static_cast<png_uint_32>(rect.extent.height);
    png.format = swapped ? PNG_FORMAT_BGRA : PNG_FORMAT_RGBA;
    if (!png_image_write_to_file(&png, (name + ".png").c_str(), 0, pixels.data(), 0, nullptr))
      log("cannot write {}", name);
    if (const auto* depth = static_cast<const XrCompositionLayerDepthInfoKHR*>(view.next)) {
      const auto values =
          read(*r.swapchains.at(depth->subImage.swapchain), depth->subImage.imageArrayIndex, depth->subImage.imageRect);
      std::ofstream(name + ".depth", std::ios::binary)
          .write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size()));
      log("depth near {} far {}", depth->nearZ, depth->farZ);
    }
  }
}

void destroy_swapchains() {
  for (auto& [handle, swapchain] : runtime().swapchains) destroy_images(*swapchain);
  runtime().swapchains.clear();
}

const Functions& swapchain_functions() {
  static const Functions table{
      {"xrEnumerateSwapchainFormats", plain(formats)}, {"xrCreateSwapchain", plain(create)},
      {"xrDestroySwapchain", plain(destroy)},          {"xrEnumerateSwapchainImages", plain(images)},
      {"xrAcquireSwapchainImage", plain(acquire)},     {"xrWaitSwapchainImage", plain(wait)},
      {"xrReleaseSwapchainImage", plain(release)},
  };
  return table;
}

}  // namespace typodont::test::xr
