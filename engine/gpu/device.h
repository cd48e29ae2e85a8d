// A thin layer over Vulkan: instance, one device, one queue, and sub-allocated memory. The objects are structs with the
// functions create and destroy.
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

/// The GPU was reset or its driver failed. All objects of the device are lost; a new device can create them again.
class DeviceLost : public RunFailure {
 public:
  using RunFailure::RunFailure;
};

/// Throws DeviceLost or RunFailure, with the call's name, unless the result is VK_SUCCESS.
void check(VkResult result, const char* call);

/// Manages a range of numbers, for example the offsets in a memory block: allocates the first free range that is large
/// enough (first fit), and merges free ranges that touch each other. Independent of Vulkan.
class RangeAllocator {
 public:
  static constexpr std::uint64_t kNone = ~0ull;
  RangeAllocator() = default;
  explicit RangeAllocator(std::uint64_t size);
  /// Allocates a range of `count` numbers. Returns its first number, or kNone if no free range is large enough.
  std::uint64_t allocate(std::uint64_t count, std::uint64_t alignment = 1);
  void release(std::uint64_t start, std::uint64_t count);
  std::uint64_t free() const { return free_; }
  std::uint64_t size() const { return size_; }
  std::size_t pieces() const { return ranges_.size(); }

 private:
  // free ranges; key: first number of a range; value: count of its numbers
  std::map<std::uint64_t, std::uint64_t> ranges_;
  std::uint64_t size_ = 0, free_ = 0;
};

struct Allocation {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize offset = 0, size = 0;
  std::byte* mapped = nullptr;  // address for the host; null if the host cannot access the memory
  int block = -1;
};

struct DeviceOptions {
  /// true: the validation layer is loaded, and its messages are counted and printed
  bool validation = false;
  std::vector<const char*> instance_extensions;  // instance extensions that a window needs
  bool present = false;                          // true: the device must support swapchains
  bool doubles = false;                          // true: the device must support double precision in shaders
  std::string prefer;  // part of the preferred device's name; empty: GPUs are preferred to CPU devices
  // For headsets, the headset's runtime creates instance and device itself (XR_KHR_vulkan_enable2), through these
  // functions. If they are empty, the program creates them through Vulkan.
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
  // true: both eyes are drawn in one pass. False for lavapipe 22.3, which has two bugs: clipped triangles lose their
  // view index and appear in the other eye, and only the first layer of a multisampled pass is resolved.
  bool multiview = true;
  bool processor = false;  // true: the Vulkan device is a CPU (software renderer), so details are omitted
  int max_samples = 1;
  // pipelines that are stored between runs (driver_cache.h); null: none are stored
  VkPipelineCache pipelines = VK_NULL_HANDLE;

  /// Creates the device. Throws Error with installation instructions if there is no Vulkan 1.3 device.
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

/// The Vulkan devices of this machine, best first: name, type, Vulkan version. Empty without a loader or driver.
struct DeviceInfo {
  std::string name;
  bool processor = false;
  std::uint32_t api_version = 0;
};
std::vector<DeviceInfo> list_devices();

/// Two frames in flight: command buffers, fences, and the number of the last frame that the GPU has finished.
struct FrameRing {
  static constexpr int kSlots = 2;
  struct Slot {
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence done = VK_NULL_HANDLE;
    std::uint64_t frame = 0;
  };
  std::array<Slot, kSlots> slots;
  std::uint64_t submitted = 0;  // number of the frame that is being recorded or was last submitted
  // number of the newest frame that the GPU has finished; all earlier frames are finished, too
  std::uint64_t finished = 0;

  static FrameRing create(Device& device);
  void destroy(Device& device);

  /// Waits until the last frame in this slot (frame in flight) has finished, then begins the slot's command buffer.
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

/// Records commands, submits them and waits until they have finished. For set-up and read-back.
void run_once(Device& device, const std::function<void(VkCommandBuffer)>& record);

}  // namespace typodont::gpu
