// Thin Vulkan: instance, device, queue, sub-allocated memory; structs with create and destroy.
#pragma once

#include <vulkan/vulkan.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/error.h"

namespace typodont::gpu {

/// Reset or failed driver: all objects are lost, a new device can be created.
class DeviceLost : public RunFailure {
 public:
  using RunFailure::RunFailure;
};

/// Throws DeviceLost or RunFailure with the call's name.
void check(VkResult result, const char* call);

/// First-fit ranges of numbers, merged when freed. No Vulkan.
class RangeAllocator {
 public:
  static constexpr std::uint64_t kNone = ~0ull;
  RangeAllocator() = default;
  explicit RangeAllocator(std::uint64_t size);
  /// First number, or kNone.
  std::uint64_t allocate(std::uint64_t count, std::uint64_t alignment = 1);
  void release(std::uint64_t start, std::uint64_t count);
  std::uint64_t free() const { return free_; }
  std::uint64_t size() const { return size_; }
  std::size_t pieces() const { return ranges_.size(); }

 private:
  // first number → count
  std::map<std::uint64_t, std::uint64_t> ranges_;
  std::uint64_t size_ = 0, free_ = 0;
};

struct Allocation {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize offset = 0, size = 0;
  std::byte* mapped = nullptr;  // null: not accessible to the host
  int block = -1;
};

struct DeviceOptions {
  /// validation layer; its messages are counted and printed
  bool validation = false;
  std::vector<const char*> instance_extensions;  // instance extensions that a window needs
  bool present = false;                          // true: the device must support swapchains
  bool doubles = false;                          // true: the device must support double precision in shaders
  std::string prefer;                            // part of the preferred device's name; empty: GPUs first
  // A headset's runtime creates both (XR_KHR_vulkan_enable2); empty: the program does.
  std::function<VkResult(const VkInstanceCreateInfo&, VkInstance&)> create_instance;
  std::function<VkPhysicalDevice(VkInstance)> choose_physical;
  std::function<VkResult(VkPhysicalDevice, const VkDeviceCreateInfo&, VkDevice&)> create_device;
};

/// A Vulkan device with its queue and memory. Render thread only.
struct Device {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;
  VkQueue queue = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties{};
  VkPhysicalDeviceMemoryProperties memory_properties{};
  // Both eyes in a pass. Not with lavapipe 22.3: clipped triangles lose their view, and only layer 0 of a multisampled
  // pass is resolved.
  bool multiview = true;
  bool processor = false;  // software renderer: details are omitted
  int max_samples = 1;
  // pipelines that are stored between runs (driver_cache.h); null: none are stored
  VkPipelineCache pipelines = VK_NULL_HANDLE;

  /// Throws Error, with how to install, without Vulkan 1.3.
  static Device create(const DeviceOptions& options);
  void destroy();

  /// Lets the next submission fail with DeviceLost. Only for tests.
  void lose() { lose_ = true; }
  bool take_loss() { return std::exchange(lose_, false); }

  int validation_messages() const;  // returns the number of validation warnings and errors so far
  std::string name() const { return properties.deviceName; }

  Allocation allocate(const VkMemoryRequirements& requirements, VkMemoryPropertyFlags required,
                      VkMemoryPropertyFlags preferred, bool image);
  void release(const Allocation& allocation);
  std::uint64_t memory_used() const;

 private:
  bool lose_ = false;
  struct Block {
    VkDeviceMemory memory = VK_NULL_HANDLE;
    std::byte* mapped = nullptr;
    std::uint32_t type = 0;
    bool image = false;
    RangeAllocator ranges;
  };
  std::vector<Block> blocks_;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  std::shared_ptr<int> messages_;
};

/// Best first; empty without loader or driver.
struct DeviceInfo {
  std::string name;
  bool processor = false;
  std::uint32_t api_version = 0;
};
std::vector<DeviceInfo> list_devices();

/// Two frames in flight.
struct FrameRing {
  static constexpr int kSlots = 2;
  struct Slot {
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence done = VK_NULL_HANDLE;
    std::uint64_t frame = 0;
  };
  std::array<Slot, kSlots> slots;
  std::uint64_t submitted = 0;  // being recorded, or last submitted
  // newest finished; all earlier ones are, too
  std::uint64_t finished = 0;

  static FrameRing create(Device& device);
  void destroy(Device& device);

  /// Waits for the slot's last frame, then begins its commands.
  VkCommandBuffer begin(Device& device);
  int slot() const { return static_cast<int>(submitted % kSlots); }
  /// Submits the commands to the queue; both semaphores may be null.
  void submit(Device& device, VkSemaphore wait = VK_NULL_HANDLE, VkSemaphore signal = VK_NULL_HANDLE);
  /// Ends the command buffer without submitting it.
  void abandon(Device& device);
  /// Waits for the last submission of a slot (frame in flight).
  void wait(Device& device, int of_slot);
  void wait_idle(Device& device);
};

/// Submits and waits. For set-up and read-back.
void run_once(Device& device, const std::function<void(VkCommandBuffer)>& record);

}  // namespace typodont::gpu
