#include "engine/gpu/device.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/memory.h"
#include "engine/gpu/driver_cache.h"
#include "engine/gpu/resources.h"

namespace typodont::gpu {

namespace {

// Memory that must be free before a call. A driver that compiles shaders for the CPU crashes if it runs out of memory.
constexpr std::size_t kRoomForDriver = 256 << 20, kRoomForDevice = 512 << 20, kRoomToDraw = 128 << 20;  // bytes

constexpr VkDeviceSize kBlockSize = VkDeviceSize{32} << 20;
constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

const char* name_of(VkResult result) {
  static const std::map<VkResult, const char*> kNames{{VK_ERROR_OUT_OF_HOST_MEMORY, "out of host memory"},
                                                      {VK_ERROR_OUT_OF_DEVICE_MEMORY, "out of device memory"},
                                                      {VK_ERROR_DEVICE_LOST, "device lost"},
                                                      {VK_ERROR_SURFACE_LOST_KHR, "surface lost"},
                                                      {VK_ERROR_INITIALIZATION_FAILED, "initialization failed"},
                                                      {VK_ERROR_FEATURE_NOT_PRESENT, "feature not present"},
                                                      {VK_ERROR_EXTENSION_NOT_PRESENT, "extension not present"},
                                                      {VK_ERROR_INCOMPATIBLE_DRIVER, "no Vulkan driver"},
                                                      {VK_TIMEOUT, "timeout"}};
  const auto found = kNames.find(result);
  return found == kNames.end() ? "error" : found->second;
}

VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                               const VkDebugUtilsMessengerCallbackDataEXT* data, void* count) {
  ++*static_cast<std::atomic<int>*>(count);  // any thread
  log::warn("Vulkan validation: {}", data->pMessage);
  return VK_FALSE;
}

bool has_layer(const char* name) {
  std::uint32_t count = 0;
  if (vkEnumerateInstanceLayerProperties(&count, nullptr) != VK_SUCCESS) return false;
  std::vector<VkLayerProperties> layers(count);
  if (vkEnumerateInstanceLayerProperties(&count, layers.data()) != VK_SUCCESS) return false;
  return std::any_of(layers.begin(), layers.end(), [&](const auto& l) { return !std::strcmp(l.layerName, name); });
}

bool has_extension(VkPhysicalDevice device, const char* name) {
  std::uint32_t count = 0;
  if (vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr) != VK_SUCCESS) return false;
  std::vector<VkExtensionProperties> extensions(count);
  if (vkEnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data()) != VK_SUCCESS) return false;
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](const auto& e) { return !std::strcmp(e.extensionName, name); });
}

VkInstance create_instance(const DeviceOptions& options, VkDebugUtilsMessengerCreateInfoEXT* messenger) {
  std::vector<const char*> extensions = options.instance_extensions, layers;
  if (options.validation) {
    layers.push_back(kValidationLayer);
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  }
  const VkApplicationInfo application{
      .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "typodont", .apiVersion = VK_API_VERSION_1_3};
  const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                  .pNext = options.validation ? messenger : nullptr,
                                  .pApplicationInfo = &application,
                                  .enabledLayerCount = static_cast<std::uint32_t>(layers.size()),
                                  .ppEnabledLayerNames = layers.data(),
                                  .enabledExtensionCount = static_cast<std::uint32_t>(extensions.size()),
                                  .ppEnabledExtensionNames = extensions.data()};
  VkInstance instance = VK_NULL_HANDLE;
  const VkResult result =
      options.create_instance ? options.create_instance(info, instance) : vkCreateInstance(&info, nullptr, &instance);
  if (result != VK_SUCCESS)
    throw Error("Vulkan", "", name_of(result),
                "a Vulkan driver (apt install mesa-vulkan-drivers gives one that needs no GPU)");
  return instance;
}

std::vector<VkPhysicalDevice> physical_devices(VkInstance instance) {
  std::uint32_t count = 0;
  if (vkEnumeratePhysicalDevices(instance, &count, nullptr) != VK_SUCCESS) return {};
  std::vector<VkPhysicalDevice> devices(count);
  if (vkEnumeratePhysicalDevices(instance, &count, devices.data()) < 0) return {};
  return devices;
}

/// Place of the device in the order of preference.
int rank(const VkPhysicalDeviceProperties& p) {
  constexpr std::array kBestFirst{VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU, VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU,
                                  VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU, VK_PHYSICAL_DEVICE_TYPE_CPU};
  return static_cast<int>(std::ranges::find(kBestFirst, p.deviceType) - kBestFirst.begin());
}

}  // namespace

void check(VkResult result, const char* call) {
  if (result == VK_ERROR_DEVICE_LOST) throw DeviceLost(fmt::format("{}: the device is lost", call));
  if (result != VK_SUCCESS)
    throw RunFailure(fmt::format("{}: {} ({})", call, name_of(result), static_cast<int>(result)));
}

RangeAllocator::RangeAllocator(std::uint64_t size) : size_(size), free_(size) {
  if (size) ranges_.emplace(0, size);
}

std::uint64_t RangeAllocator::allocate(std::uint64_t count, std::uint64_t alignment) {
  for (auto it = ranges_.begin(); it != ranges_.end(); ++it) {
    const auto [start, length] = *it;
    const std::uint64_t aligned = (start + alignment - 1) / alignment * alignment;
    if (aligned + count > start + length) continue;
    ranges_.erase(it);
    if (aligned > start) ranges_.emplace(start, aligned - start);
    if (aligned + count < start + length) ranges_.emplace(aligned + count, start + length - aligned - count);
    free_ -= count;
    return aligned;
  }
  return kNone;
}

void RangeAllocator::release(std::uint64_t start, std::uint64_t count) {
  if (!count) return;
  free_ += count;
  auto next = ranges_.lower_bound(start);
  if (next != ranges_.end() && next->first == start + count) {
    count += next->second;
    next = ranges_.erase(next);
  }
  if (next != ranges_.begin()) {
    auto previous = std::prev(next);
    if (previous->first + previous->second == start) {
      previous->second += count;
      return;
    }
  }
  ranges_.emplace(start, count);
}

Device Device::create(const DeviceOptions& options) {
  if (options.validation && !has_layer(kValidationLayer))
    throw Error("Vulkan", "", "no validation layer", "apt install vulkan-validationlayers");
  require_memory(kRoomForDriver);
  Device d;
  d.messages_ = std::make_shared<std::atomic<int>>(0);
  check_driver_cache();
  VkDebugUtilsMessengerCreateInfoEXT messenger{
      .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
      .messageSeverity =
          VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
      .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
      .pfnUserCallback = on_message,
      .pUserData = d.messages_.get()};
  d.instance = create_instance(options, &messenger);
  try {
    if (options.validation) {
      const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
          vkGetInstanceProcAddr(d.instance, "vkCreateDebugUtilsMessengerEXT"));
      if (create) check(create(d.instance, &messenger, nullptr, &d.messenger_), "vkCreateDebugUtilsMessengerEXT");
    }

    // Chooses the best device that supports everything the renderer needs.
    int best = 1000;
    std::string seen;
    const std::vector<VkPhysicalDevice> candidates =
        options.choose_physical ? std::vector{options.choose_physical(d.instance)} : physical_devices(d.instance);
    for (VkPhysicalDevice physical : candidates) {
      VkPhysicalDeviceProperties properties;
      vkGetPhysicalDeviceProperties(physical, &properties);
      seen += fmt::format("{}{} (Vulkan {}.{})", seen.empty() ? "" : ", ", properties.deviceName,
                          VK_API_VERSION_MAJOR(properties.apiVersion), VK_API_VERSION_MINOR(properties.apiVersion));
      if (properties.apiVersion < VK_API_VERSION_1_3) continue;
      if (options.present && !has_extension(physical, VK_KHR_SWAPCHAIN_EXTENSION_NAME)) continue;
      if (!options.prefer.empty() && std::string(properties.deviceName).find(options.prefer) == std::string::npos)
        continue;
      if (rank(properties) >= best) continue;
      best = rank(properties);
      d.physical = physical;
      d.properties = properties;
    }
    if (!d.physical)
      throw Error("Vulkan", "", seen.empty() ? "no device" : seen,
                  "a device with Vulkan 1.3 (apt install mesa-vulkan-drivers gives one that needs no GPU)");

    VkPhysicalDeviceDriverProperties driver{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceProperties2 properties2{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &driver};
    vkGetPhysicalDeviceProperties2(d.physical, &properties2);
    d.multiview = driver.driverID != VK_DRIVER_ID_MESA_LLVMPIPE;
    d.processor = d.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    vkGetPhysicalDeviceMemoryProperties(d.physical, &d.memory_properties);
    const VkSampleCountFlags counts =
        d.properties.limits.framebufferColorSampleCounts & d.properties.limits.framebufferDepthSampleCounts;
    for (int samples : {1, 2, 4, 8})
      if (counts & static_cast<VkSampleCountFlags>(samples)) d.max_samples = samples;

    // On all known drivers, a queue family that draws and computes can also present to a window.
    std::uint32_t families = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(d.physical, &families, nullptr);
    std::vector<VkQueueFamilyProperties> family(families);
    vkGetPhysicalDeviceQueueFamilyProperties(d.physical, &families, family.data());
    constexpr VkQueueFlags kNeeded = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    d.queue_family = families;
    for (std::uint32_t i = 0; i < families && d.queue_family == families; ++i)
      if ((family[i].queueFlags & kNeeded) == kNeeded) d.queue_family = i;
    if (d.queue_family == families) throw Error("Vulkan", d.name(), "no queue that draws", "a graphics queue");

    const float priority = 1;
    const VkDeviceQueueCreateInfo queue{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                        .queueFamilyIndex = d.queue_family,
                                        .queueCount = 1,
                                        .pQueuePriorities = &priority};
    VkPhysicalDeviceVulkan13Features v13{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
                                         .synchronization2 = VK_TRUE,
                                         .dynamicRendering = VK_TRUE,
                                         .maintenance4 = VK_TRUE};
    VkPhysicalDeviceVulkan11Features v11{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES, .pNext = &v13, .multiview = VK_TRUE};
    VkPhysicalDeviceFeatures2 features{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                       .pNext = &v11,
                                       .features = {.multiDrawIndirect = VK_TRUE, .shaderClipDistance = VK_TRUE}};
    std::vector<const char*> extensions;
    if (options.present) extensions.push_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);
    const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                  .pNext = &features,
                                  .queueCreateInfoCount = 1,
                                  .pQueueCreateInfos = &queue,
                                  .enabledExtensionCount = static_cast<std::uint32_t>(extensions.size()),
                                  .ppEnabledExtensionNames = extensions.data()};
    if (d.processor) require_memory(kRoomForDevice);  // the driver crashes if its threads get no memory
    const VkResult result = options.create_device ? options.create_device(d.physical, info, d.device)
                                                  : vkCreateDevice(d.physical, &info, nullptr, &d.device);
    if (result != VK_SUCCESS)
      throw Error("Vulkan", d.name(), name_of(result), "multiview, dynamic rendering and multiDrawIndirect");
    vkGetDeviceQueue(d.device, d.queue_family, 0, &d.queue);
    d.pipelines = open_pipelines(d.device, d.properties);
  } catch (...) {
    d.destroy();
    throw;
  }
  return d;
}

void Device::destroy() {
  if (device) {
    vkDeviceWaitIdle(device);
    for (Block& block : blocks_) vkFreeMemory(device, block.memory, nullptr);
    blocks_.clear();
    destroy_pipelines(*this);
    close_pipelines(device, properties, std::exchange(pipelines, VK_NULL_HANDLE));
    vkDestroyDevice(device, nullptr);
    device = VK_NULL_HANDLE;
  }
  if (instance) {
    if (messenger_) {
      const auto destroy_messenger = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
          vkGetInstanceProcAddr(instance, "vkDestroyDebugUtilsMessengerEXT"));
      destroy_messenger(instance, messenger_, nullptr);
      messenger_ = VK_NULL_HANDLE;
    }
    vkDestroyInstance(instance, nullptr);
    instance = VK_NULL_HANDLE;
    list_driver_cache();
  }
}

int Device::validation_messages() const {
  return *messages_;
}

Allocation Device::allocate(const VkMemoryRequirements& requirements, VkMemoryPropertyFlags required,
                            VkMemoryPropertyFlags preferred, bool image) {
  // Takes a memory type with all required and preferred properties, or else one with all required properties.
  std::uint32_t type = VK_MAX_MEMORY_TYPES;
  for (const VkMemoryPropertyFlags wanted : {required | preferred, required}) {
    for (std::uint32_t i = 0; i < memory_properties.memoryTypeCount && type == VK_MAX_MEMORY_TYPES; ++i)
      if ((requirements.memoryTypeBits & (1u << i)) &&
          (memory_properties.memoryTypes[i].propertyFlags & wanted) == wanted)
        type = i;
  }
  if (type == VK_MAX_MEMORY_TYPES) throw RunFailure("Vulkan: no memory type fits");

  // Images and buffers lie in separate blocks, so that bufferImageGranularity has no effect.
  const bool own_block = requirements.size > kBlockSize / 4;
  if (!own_block)
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      Block& block = blocks_[i];
      if (!block.memory || block.type != type || block.image != image) continue;
      const std::uint64_t offset = block.ranges.allocate(requirements.size, requirements.alignment);
      if (offset != RangeAllocator::kNone)
        return {block.memory, offset, requirements.size, block.mapped ? block.mapped + offset : nullptr,
                static_cast<int>(i)};
    }

  Block block;
  block.type = type;
  block.image = image;
  const VkDeviceSize size = own_block ? requirements.size : kBlockSize;
  block.ranges = RangeAllocator(size);
  const VkMemoryAllocateInfo info{
      .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = size, .memoryTypeIndex = type};
  check(vkAllocateMemory(device, &info, nullptr, &block.memory), "vkAllocateMemory");
  if (memory_properties.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) {
    void* mapped = nullptr;
    check(vkMapMemory(device, block.memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
    block.mapped = static_cast<std::byte*>(mapped);
  }
  const std::uint64_t offset = block.ranges.allocate(requirements.size, requirements.alignment);
  const auto free_place = std::find_if(blocks_.begin(), blocks_.end(), [](const Block& b) { return !b.memory; });
  const int index = static_cast<int>(free_place - blocks_.begin());
  const Allocation allocation{block.memory, offset, requirements.size, block.mapped ? block.mapped + offset : nullptr,
                              index};
  if (free_place == blocks_.end())
    blocks_.push_back(std::move(block));
  else
    *free_place = std::move(block);
  return allocation;
}

void Device::release(const Allocation& allocation) {
  if (allocation.block < 0) return;
  Block& block = blocks_[static_cast<std::size_t>(allocation.block)];
  block.ranges.release(allocation.offset, allocation.size);
  if (block.ranges.free() == block.ranges.size()) {
    vkFreeMemory(device, block.memory, nullptr);
    block = Block{};
  }
}

std::uint64_t Device::memory_used() const {
  std::uint64_t used = 0;
  for (const Block& block : blocks_) used += block.ranges.size() - block.ranges.free();
  return used;
}

std::vector<DeviceInfo> list_devices() {
  std::vector<DeviceInfo> list;
  VkInstance instance = VK_NULL_HANDLE;
  try {
    instance = create_instance({}, nullptr);
  } catch (const Error&) {
    return list;  // without a loader or driver, the list stays empty
  }
  std::vector<std::pair<int, DeviceInfo>> ranked;
  for (VkPhysicalDevice physical : physical_devices(instance)) {
    VkPhysicalDeviceProperties p;
    vkGetPhysicalDeviceProperties(physical, &p);
    ranked.push_back({rank(p), {p.deviceName, p.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU, p.apiVersion}});
  }
  vkDestroyInstance(instance, nullptr);
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (auto& [unused, info] : ranked) list.push_back(std::move(info));
  return list;
}

FrameRing FrameRing::create(Device& device) {
  FrameRing ring;
  for (Slot& slot : ring.slots) {
    const VkCommandPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                       .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                       .queueFamilyIndex = device.queue_family};
    check(vkCreateCommandPool(device.device, &pool, nullptr, &slot.pool), "vkCreateCommandPool");
    const VkCommandBufferAllocateInfo buffer{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                             .commandPool = slot.pool,
                                             .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                             .commandBufferCount = 1};
    check(vkAllocateCommandBuffers(device.device, &buffer, &slot.commands), "vkAllocateCommandBuffers");
    const VkFenceCreateInfo fence{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, .flags = VK_FENCE_CREATE_SIGNALED_BIT};
    check(vkCreateFence(device.device, &fence, nullptr, &slot.done), "vkCreateFence");
  }
  return ring;
}

void FrameRing::destroy(Device& device) {
  for (Slot& slot : slots) {
    if (slot.done) vkDestroyFence(device.device, slot.done, nullptr);
    if (slot.pool) vkDestroyCommandPool(device.device, slot.pool, nullptr);
    slot = {};
  }
}

VkCommandBuffer FrameRing::begin(Device& device) {
  ++submitted;
  Slot& s = slots[static_cast<std::size_t>(slot())];
  check(vkWaitForFences(device.device, 1, &s.done, VK_TRUE, UINT64_MAX), "vkWaitForFences");
  finished = std::max(finished, s.frame);
  s.frame = submitted;
  check(vkResetCommandPool(device.device, s.pool, 0), "vkResetCommandPool");
  const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                       .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  check(vkBeginCommandBuffer(s.commands, &begin), "vkBeginCommandBuffer");
  return s.commands;
}

void FrameRing::submit(Device& device, VkSemaphore wait, VkSemaphore signal) {
  Slot& s = slots[static_cast<std::size_t>(slot())];
  check(vkEndCommandBuffer(s.commands), "vkEndCommandBuffer");
  if (device.take_loss()) check(VK_ERROR_DEVICE_LOST, "vkQueueSubmit2");
  const VkCommandBufferSubmitInfo commands{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                           .commandBuffer = s.commands};
  const VkSemaphoreSubmitInfo wait_info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                        .semaphore = wait,
                                        .stageMask = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT};
  const VkSemaphoreSubmitInfo signal_info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                          .semaphore = signal,
                                          .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
  const VkSubmitInfo2 info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                           .waitSemaphoreInfoCount = wait ? 1u : 0u,
                           .pWaitSemaphoreInfos = &wait_info,
                           .commandBufferInfoCount = 1,
                           .pCommandBufferInfos = &commands,
                           .signalSemaphoreInfoCount = signal ? 1u : 0u,
                           .pSignalSemaphoreInfos = &signal_info};
  if (device.processor) require_memory(kRoomToDraw);
  check(vkResetFences(device.device, 1, &s.done), "vkResetFences");
  check(vkQueueSubmit2(device.queue, 1, &info, s.done), "vkQueueSubmit2");
}

void FrameRing::abandon(Device&) {
  check(vkEndCommandBuffer(slots[static_cast<std::size_t>(slot())].commands), "vkEndCommandBuffer");
}

void FrameRing::wait(Device& device, int of_slot) {
  check(vkWaitForFences(device.device, 1, &slots[static_cast<std::size_t>(of_slot)].done, VK_TRUE, UINT64_MAX),
        "vkWaitForFences");
}

bool FrameRing::done(Device& device, int of_slot) const {
  const VkResult result = vkGetFenceStatus(device.device, slots[static_cast<std::size_t>(of_slot)].done);
  if (result == VK_NOT_READY) return false;
  check(result, "vkGetFenceStatus");
  return true;
}

void FrameRing::wait_idle(Device& device) {
  for (Slot& s : slots) check(vkWaitForFences(device.device, 1, &s.done, VK_TRUE, UINT64_MAX), "vkWaitForFences");
  finished = submitted;
}

void run_once(Device& device, const std::function<void(VkCommandBuffer)>& record) {
  FrameRing ring = FrameRing::create(device);
  try {
    const VkCommandBuffer commands = ring.begin(device);
    record(commands);
    ring.submit(device);
    ring.wait_idle(device);
  } catch (...) {
    ring.destroy(device);
    throw;
  }
  ring.destroy(device);
}

}  // namespace typodont::gpu
