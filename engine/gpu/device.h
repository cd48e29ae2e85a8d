// Thin layer over Vulkan: instance, device, queue and sub-allocated memory. Structs have create() and destroy().
#pragma once

#include <vulkan/vulkan.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/base/clock.h"
#include "engine/base/error.h"

namespace typodont::gpu {

/// The driver failed or was reset. All Vulkan objects are lost, but a new device can be created.
class DeviceLost : public RunFailure {
 public:
  using RunFailure::RunFailure;
};
/// A device that is lost earlier than this after it was created again is broken, ns.
inline constexpr Nanos kReviveInterval = 10 * kNanosPerSecond;

/// Throws DeviceLost or RunFailure with the name of the call if `result` is an error.
void check(VkResult result, const char* call);

/// Allocates ranges of numbers by first fit and merges freed ranges. Does not use Vulkan.
class RangeAllocator {
 public:
  static constexpr std::uint64_t kNone = ~0ull;
  RangeAllocator() = default;
  explicit RangeAllocator(std::uint64_t size);
  /// Returns the first number of the range, or kNone if there is no space.
  std::uint64_t allocate(std::uint64_t count, std::uint64_t alignment = 1);
  void release(std::uint64_t start, std::uint64_t count);
  std::uint64_t free() const { return free_; }
  std::uint64_t size() const { return size_; }
  std::size_t pieces() const { return ranges_.size(); }

 private:
  // free ranges: first number of each range → count of its numbers
  std::map<std::uint64_t, std::uint64_t> ranges_;
  std::uint64_t size_ = 0, free_ = 0;
};

struct Allocation {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize offset = 0, size = 0;
  std::byte* mapped = nullptr;  // address for the host; null: no access by the host
  int block = -1;
};

struct DeviceOptions {
  /// true: uses the validation layer; messages are counted and printed
  bool validation = false;
  std::vector<const char*> instance_extensions;  // instance extensions that a window needs
  bool present = false;                          // true: the device must support swapchains
  std::string prefer;                            // part of the preferred device's name; empty: GPUs are preferred
  // A headset's runtime creates the instance and the device with these functions (XR_KHR_vulkan_enable2). Empty: the
  // program creates them.
  std::function<VkResult(const VkInstanceCreateInfo&, VkInstance&)> create_instance;
  std::function<VkPhysicalDevice(VkInstance)> choose_physical;
  std::function<VkResult(VkPhysicalDevice, const VkDeviceCreateInfo&, VkDevice&)> create_device;
};

/// A Vulkan device with queue and memory. Render thread only.
struct Device {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;
  VkQueue queue = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties{};
  VkPhysicalDeviceMemoryProperties memory_properties{};
  // true: one pass can draw both eyes. False for lavapipe 22.3: clipped triangles lose their view index, and of a
  // multisampled pass only layer 0 is resolved.
  bool multiview = true;
  bool processor = false;  // true: software renderer; some details are not drawn with it
  int max_samples = 1;
  // pipelines stored between runs (driver_cache.h); null: none are stored
  VkPipelineCache pipelines = VK_NULL_HANDLE;
  // graphics pipelines, by their options (get_pipeline() in resources.h). The first thread that waits for a pipeline
  // creates it.
  std::map<std::vector<std::uint64_t>, std::shared_future<VkPipeline>> created_pipelines;
  std::vector<std::jthread> pipeline_threads;  // the threads of prepare_pipelines()
  int unprepared_pipelines = 0;                // number of pipelines that get_pipeline() created unprepared

  /// Throws Error with installation instructions if Vulkan 1.3 is missing.
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
  /// Memory in use on the device, bytes.
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
  std::shared_ptr<std::atomic<int>> messages_;
};

/// A Vulkan device of this machine. list_devices() returns the best first, and an empty list without a loader or
/// driver.
struct DeviceInfo {
  std::string name;
  bool processor = false;
  std::uint32_t api_version = 0;
};
std::vector<DeviceInfo> list_devices();

/// Command buffers of two frames in flight.
struct FrameRing {
  static constexpr int kSlots = 2;
  struct Slot {
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence done = VK_NULL_HANDLE;
    std::uint64_t frame = 0;
  };
  std::array<Slot, kSlots> slots;
  std::uint64_t submitted = 0;  // number of the frame that is being recorded or was submitted last
  // number of the newest finished frame; all earlier ones are finished, too
  std::uint64_t finished = 0;

  static FrameRing create(Device& device);
  void destroy(Device& device);

  /// Waits for the last frame of the slot, then begins recording its commands.
  VkCommandBuffer begin(Device& device);
  int slot() const { return static_cast<int>(submitted % kSlots); }
  /// Submits the commands to the queue; semaphores may be null.
  void submit(Device& device, VkSemaphore wait = VK_NULL_HANDLE, VkSemaphore signal = VK_NULL_HANDLE);
  /// Ends the command buffer without submitting it.
  void abandon(Device& device);
  /// Waits until the GPU has finished the last submission of a slot (frame in flight).
  void wait(Device& device, int of_slot);
  /// True if wait() would return at once.
  bool done(Device& device, int of_slot) const;
  void wait_idle(Device& device);
};

/// Records commands, submits them and waits for their end. Used for set-up and read-back.
void run_once(Device& device, const std::function<void(VkCommandBuffer)>& record);

}  // namespace typodont::gpu
