// Vulkan, thin: the instance, one device, one queue, and memory cut into pieces. Structs with create and destroy.
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

/// The GPU was reset, or its driver gave up: everything made on it is gone, and may be made anew.
class DeviceLost : public RunFailure {
 public:
  using RunFailure::RunFailure;
};

/// Throws DeviceLost or RunFailure naming the call unless the result is VK_SUCCESS.
void check(VkResult result, const char* call);

/// Free ranges of something counted, first fit, neighbours merged. Knows nothing of Vulkan.
class RangeAllocator {
 public:
  static constexpr std::uint64_t kNone = ~0ull;
  RangeAllocator() = default;
  explicit RangeAllocator(std::uint64_t size);
  std::uint64_t allocate(std::uint64_t count, std::uint64_t alignment = 1);  // kNone when nothing fits
  void release(std::uint64_t start, std::uint64_t count);
  std::uint64_t free() const { return free_; }
  std::uint64_t size() const { return size_; }
  std::size_t pieces() const { return ranges_.size(); }

 private:
  std::map<std::uint64_t, std::uint64_t> ranges_;  // start → count
  std::uint64_t size_ = 0, free_ = 0;
};

struct Allocation {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize offset = 0, size = 0;
  std::byte* mapped = nullptr;  // where the host sees it, if it does
  int block = -1;
};

struct DeviceOptions {
  bool validation = false;                       // the validation layer, each of its messages counted and printed
  std::vector<const char*> instance_extensions;  // a window's
  bool present = false;                          // swapchains
  bool doubles = false;                          // shaders compute in double precision
  std::string prefer;                            // a part of the device's name; empty: a GPU before a processor
  // Where a headset's runtime must make them (XR_KHR_vulkan_enable2); empty: Vulkan itself does.
  std::function<VkResult(const VkInstanceCreateInfo&, VkInstance&)> create_instance;
  std::function<VkPhysicalDevice(VkInstance)> choose_physical;
  std::function<VkResult(VkPhysicalDevice, const VkDeviceCreateInfo&, VkDevice&)> create_device;
};

/// Render thread.
struct Device {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;
  VkQueue queue = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties{};
  VkPhysicalDeviceMemoryProperties memory_properties{};
  // Both eyes can be drawn in one pass. Not on lavapipe 22.3: triangles it clips lose their view and land in the other
  // eye, and only the first layer of a multisampled pass is resolved.
  bool multiview = true;
  bool processor = false;  // a processor plays the GPU: keep the frame cheap
  int max_samples = 1;
  VkPipelineCache pipelines =
      VK_NULL_HANDLE;  // as kept between runs (driver_cache.h); null: the driver does as it does

  /// Throws Error with what to install when there is no Vulkan 1.3 device.
  static Device create(const DeviceOptions& options);
  void destroy();

  /// The next submission fails as if the device were lost: for tests of what then happens.
  void lose() { lose_ = true; }
  bool take_loss() { return std::exchange(lose_, false); }

  int validation_messages() const;  // warnings and errors so far
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

/// The devices this machine offers, best first: name, type, Vulkan version. Empty where there is no loader or driver.
struct DeviceInfo {
  std::string name;
  bool processor = false;
  std::uint32_t api_version = 0;
};
std::vector<DeviceInfo> list_devices();

/// Two frames in flight: command buffers, fences, and which frames the GPU has finished.
struct FrameRing {
  static constexpr int kSlots = 2;
  struct Slot {
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence done = VK_NULL_HANDLE;
    std::uint64_t frame = 0;
  };
  std::array<Slot, kSlots> slots;
  std::uint64_t submitted = 0;  // number of the frame being recorded or last submitted
  std::uint64_t finished = 0;   // all frames up to this one are done

  static FrameRing create(Device& device);
  void destroy(Device& device);

  /// Waits for the slot's last frame, then opens its command buffer.
  VkCommandBuffer begin(Device& device);
  int slot() const { return static_cast<int>(submitted % kSlots); }
  /// Gives the commands to the queue; semaphores may be null.
  void submit(Device& device, VkSemaphore wait = VK_NULL_HANDLE, VkSemaphore signal = VK_NULL_HANDLE);
  /// Closes the command buffer unused.
  void abandon(Device& device);
  /// For what was last submitted in a slot.
  void wait(Device& device, int of_slot);
  void wait_idle(Device& device);
};

/// Records, submits and waits: set-up and read-back.
void run_once(Device& device, const std::function<void(VkCommandBuffer)>& record);

}  // namespace typodont::gpu
