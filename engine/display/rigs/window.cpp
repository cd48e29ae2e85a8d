// A GLFW window. Vulkan presents its pictures, or the CPU copies them to the X server through shared memory. Handles
// resizing, minimising and lost surfaces; a lost device is handled by the caller.
#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <thread>
#include <utility>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/late_library.h"
#include "engine/display/button_queue.h"
#include "engine/display/output.h"
#include "engine/display/rigs/desktop_events.h"
#include "engine/display/rigs/key_thread.h"
#include "engine/display/rigs/shared_picture.h"

namespace typodont::display {

namespace {

constinit LateLibrary glfw{TYPODONT_LATE_GLFW};
TYPODONT_LATE(glfw, glfwCreateWindow, glfwCreateWindowSurface, glfwDestroyWindow, glfwFocusWindow, glfwGetCursorPos,
              glfwGetError, glfwGetFramebufferSize, glfwGetKey, glfwGetKeyName, glfwGetKeyScancode,
              glfwGetMonitorContentScale, glfwGetMonitorName, glfwGetMonitorWorkarea, glfwGetMonitors,
              glfwGetPrimaryMonitor, glfwGetRequiredInstanceExtensions, glfwGetVideoMode, glfwGetWindowAttrib,
              glfwGetWindowContentScale, glfwGetWindowMonitor, glfwGetWindowPos, glfwGetWindowSize,
              glfwGetWindowUserPointer, glfwInit, glfwSetCharCallback, glfwSetDropCallback, glfwSetKeyCallback,
              glfwSetMouseButtonCallback, glfwSetScrollCallback, glfwSetWindowPos, glfwSetWindowRefreshCallback,
              glfwSetWindowSize, glfwSetWindowTitle, glfwSetWindowUserPointer, glfwVulkanSupported, glfwWindowHint,
              glfwWindowShouldClose)

/// Initialises GLFW once. GLFW stays initialised until the program ends, because windows are opened and closed.
void ensure_glfw() {
  static const bool started = glfwInit() == GLFW_TRUE;
  if (!started) {
    const char* why = nullptr;
    glfwGetError(&why);
    throw Error("window", "", why ? why : "no desktop", "a desktop session (DISPLAY or WAYLAND_DISPLAY)");
  }
  if (!glfwVulkanSupported()) throw Error("window", "", "no Vulkan on this desktop", "a Vulkan driver that presents");
}

/// Returns the code for UserInput::pressed: the key's label on the user's layout. For keys without a Latin label
/// and for the row of digits, the code depends on the key's position on the keyboard.
int code_of(int key, int scancode) {
  const bool digit = key >= GLFW_KEY_0 && key <= GLFW_KEY_9;
  const char* const label = key < GLFW_KEY_ESCAPE && !digit ? glfwGetKeyName(key, scancode) : nullptr;
  const bool latin = label && label[0] > ' ' && label[0] <= '~' && !label[1];
  return latin ? std::toupper(label[0]) : key;
}

const ivec2 kTitle(0, 30);  // pixels, space for the desktop's title bar

class Window final : public Output {
 public:
  Window(gpu::Device& device, const WindowOptions& options) : device_(device), options_(options) {
    ensure_glfw();
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    GLFWmonitor* monitor = nullptr;
    ivec2 size = options.size;
    if (options.output >= 0) {
      int count = 0;
      GLFWmonitor** monitors = glfwGetMonitors(&count);
      if (options.output >= count)
        throw Error("window", "output", fmt::format("{}", options.output),
                    fmt::format("one of the {} connected, from 0", count));
      monitor = monitors[options.output];
      const GLFWvidmode* mode = glfwGetVideoMode(monitor);
      size = {mode->width, mode->height};
    } else if (options.fits_screen && glfwGetPrimaryMonitor()) {
      ivec2 lo, room{0};
      glfwGetMonitorWorkarea(glfwGetPrimaryMonitor(), &lo.x, &lo.y, &room.x, &room.y);
      glm::vec2 scale(1);
      glfwGetMonitorContentScale(glfwGetPrimaryMonitor(), &scale.x, &scale.y);
      size = ivec2(glm::vec2(size) * scale);
      if (room.x > 0 && room.y > kTitle.y) size = glm::min(size, room - kTitle);
    }
    // A full-screen window without focus is not minimised.
    glfwWindowHint(GLFW_AUTO_ICONIFY, GLFW_FALSE);
    window_ = glfwCreateWindow(size.x, size.y, options.title.c_str(), monitor, nullptr);
    if (!window_) {
      const char* why = nullptr;
      glfwGetError(&why);
      throw Error("window", "", why ? why : "cannot be opened", "a desktop session");
    }
    glfwSetWindowUserPointer(window_, this);
    glfwSetScrollCallback(window_, [](GLFWwindow* w, double, double y) { self(w).events_.wheel += y; });
    glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { self(w).exposed_ = true; });
    glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int scancode, int action, int) {
      const int code = code_of(key, scancode);
      if (action == GLFW_PRESS) self(w).press(code);
      self(w).events_.keys.push_back({code, action != GLFW_RELEASE});
    });
    glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned code) {
      self(w).events_.keys.push_back({0, false, code});
    });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int) {
      if (button < 3) self(w).buttons_[static_cast<std::size_t>(button)].add(action == GLFW_PRESS);
    });
    glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** paths) {
      self(w).events_.dropped.insert(self(w).events_.dropped.end(), paths, paths + count);
    });
    ask();
    try {
      if (device.processor && !options.stereo_surface) shared_ = SharedPicture::open(device, window_, options.composed);
      if (shared_) {
        fit_shared();
      } else {
        create_surface();
        create_swapchain();
      }
      listen();
    } catch (...) {
      destroy();
      throw;
    }
  }
  ~Window() override { destroy(); }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  std::optional<Target> acquire() override {
    // Shows the last frame, except if the CPU composes the frames. In this case, present() shows it after the next
    // submission, so that CPU and GPU work at the same time.
    if (!(shared_ && options_.composed)) show_finished();
    limit_frame_rate();
    if (!visible()) return std::nullopt;
    if (shared_) {
      if (std::exchange(lost_, false) || stale_ || pixels_ != extent_) {
        unshown_ = false;  // the last frame is not shown, because it has the old size
        if (!fit_shared()) return std::nullopt;
      }
      exposed_ = false;
      return shared_->target();
    }
    if (lost_) {
      create_surface();
      lost_ = false;
      stale_ = true;
    }
    if (!swapchain_ || stale_ || pixels_ != wanted_) create_swapchain();
    if (!swapchain_) return std::nullopt;
    sync_ = (sync_ + 1) % ready_.size();
    const VkResult result =
        vkAcquireNextImageKHR(device_.device, swapchain_, UINT64_MAX, ready_[sync_], VK_NULL_HANDLE, &index_);
    if (!usable(result)) return std::nullopt;
    exposed_ = false;
    return Target{.image = images_[index_],
                  .layers = views_[index_],
                  .size = extent_,
                  .format = format_,
                  .final_layout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR,
                  .ready = ready_[sync_],
                  .done = done_[index_],
                  .kept = std::exchange(drawn_[index_], std::uint8_t{1}) != 0};
  }

  /// With a GPU, shows the frame at once. With software rendering, present() would wait until the frame is drawn, so
  /// the frame is shown later: at the next acquire(), present() or second poll().
  void present(const std::optional<std::vector<Part>>& drawn, std::function<void()> finish) override {
    show_finished();
    parts_ = drawn;
    finish_ = std::move(finish);
    unshown_ = true;
    polls_ = 0;
    if (!device_.processor) show_finished();
  }

  void show_finished() {
    if (!std::exchange(unshown_, false)) return;
    if (shared_) return parts_ ? shared_->show(*parts_, finish_) : shared_->show_all(finish_);
    const VkPresentInfoKHR info{.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                .waitSemaphoreCount = 1,
                                .pWaitSemaphores = &done_[index_],
                                .swapchainCount = 1,
                                .pSwapchains = &swapchain_,
                                .pImageIndices = &index_};
    usable(vkQueuePresentKHR(device_.queue, &info));
  }

  ivec2 size() const override { return extent_; }

  // On X11 a minimised window keeps its size; on other desktops the size becomes zero.
  bool visible() const override { return on_screen_ && pixels_.x > 0 && pixels_.y > 0; }
  bool needs_frame() const override { return exposed_ || stale_ || lost_ || pixels_ != wanted_; }

  void set_title(const std::string& title) override { glfwSetWindowTitle(window_, title.c_str()); }
  void take_focus() override { glfwFocusWindow(window_); }
  void leave_monitor(int taken) override {
    int count = 0;
    GLFWmonitor** all = glfwGetMonitors(&count);
    if (taken < 0 || taken >= count || count < 2) return;
    ivec2 at, size, lo, room;
    glfwGetWindowPos(window_, &at.x, &at.y);
    glfwGetWindowSize(window_, &size.x, &size.y);
    glfwGetMonitorWorkarea(all[taken], &lo.x, &lo.y, &room.x, &room.y);
    const ivec2 middle = at + size / 2 - lo;
    // nothing to do: the middle of the window is not on this monitor
    if (middle.x < 0 || middle.y < 0 || middle.x >= room.x || middle.y >= room.y) return;
    glfwGetMonitorWorkarea(all[(taken + 1) % count], &lo.x, &lo.y, &room.x, &room.y);
    const ivec2 fits = glm::min(size, room - kTitle);
    const ivec2 to = lo + glm::max((room - fits) / 2, kTitle);
    if (fits != size) glfwSetWindowSize(window_, fits.x, fits.y);
    glfwSetWindowPos(window_, to.x, to.y);
  }
  void lose_surface() override { lost_ = true; }
  void resize(ivec2 size) override {
    glfwSetWindowSize(window_, size.x, size.y);
    ask();
  }

  int first_row() const override {
    int x = 0, y = 0;
    glfwGetWindowPos(window_, &x, &y);
    return y;
  }

  double scale() const override {
    float x = 1, y = 1;
    glfwGetWindowContentScale(window_, &x, &y);
    return std::max(static_cast<double>(x), 0.5);
  }

  double refresh_period() const override { return refresh_period_; }

  UserInput poll() override {
    if (++polls_ > 1) show_finished();
    const std::uint64_t news = take_desktop_events();
    if (std::exchange(events_at_query_, news) != news) ask();
    UserInput input = std::exchange(events_, {});
    input.close = glfwWindowShouldClose(window_);
    const dvec2 at = cursor_ / dvec2(glm::max(size_, ivec2(1)));
    input.pointer = {2 * at.x - 1, 1 - 2 * at.y};
    input.left = buttons_[GLFW_MOUSE_BUTTON_LEFT].next();
    input.right = buttons_[GLFW_MOUSE_BUTTON_RIGHT].next();
    input.middle = buttons_[GLFW_MOUSE_BUTTON_MIDDLE].next();
    input.shift = glfwGetKey(window_, GLFW_KEY_LEFT_SHIFT) == GLFW_PRESS ||
                  glfwGetKey(window_, GLFW_KEY_RIGHT_SHIFT) == GLFW_PRESS;
    input.pixel = at * dvec2(extent_);
    input.focused = focused_;
    return input;
  }

  void wait(Nanos most) override { wait_for_desktop(most); }
  std::uint64_t requests() const override { return desktop_requests(); }

 private:
  static Window& self(GLFWwindow* w) { return *static_cast<Window*>(glfwGetWindowUserPointer(w)); }

  void press(int key) {
    events_.pressed.push_back(key);
    const std::vector<int>& urgent = options_.urgent.codes;
    if (!key_thread_ && std::find(urgent.begin(), urgent.end(), key) != urgent.end()) options_.urgent.pressed(key);
  }
  void listen() {
    std::vector<KeyThread::Key> keys;
    for (const int code : options_.urgent.codes) keys.push_back({glfwGetKeyScancode(code), code});
    const auto id = static_cast<std::uint32_t>(x_window(window_));
    if (!keys.empty() && id != 0) key_thread_.emplace(x_server_name(), id, std::move(keys), options_.urgent.pressed);
  }

  /// Queries size, pointer and focus; slow, because it needs a round trip.
  void ask() {
    glfwGetFramebufferSize(window_, &pixels_.x, &pixels_.y);
    glfwGetWindowSize(window_, &size_.x, &size_.y);
    glfwGetCursorPos(window_, &cursor_.x, &cursor_.y);
    on_screen_ = glfwGetWindowAttrib(window_, GLFW_VISIBLE) == GLFW_TRUE;
    focused_ = glfwGetWindowAttrib(window_, GLFW_FOCUSED) == GLFW_TRUE;
  }

  /// Time between two refreshes of the window's screen, s.
  static double period_of(GLFWwindow* window) {
    GLFWmonitor* monitor = glfwGetWindowMonitor(window);
    if (!monitor) monitor = glfwGetPrimaryMonitor();
    const GLFWvidmode* mode = monitor ? glfwGetVideoMode(monitor) : nullptr;
    return 1.0 / (mode && mode->refreshRate > 0 ? mode->refreshRate : 60);
  }

  /// Limits the frame rate, because presenting does not wait for the screen on some desktops (Xvfb).
  void limit_frame_rate() {
    const Nanos period = from_seconds(1.0 / std::max(options_.max_frames_per_second, 1.0));
    const Nanos t = now();
    if (t < next_) std::this_thread::sleep_for(std::chrono::nanoseconds(next_ - t));
    next_ = std::max(next_, t) + period;
  }

  /// Returns false if the frame could not be shown. Sets `stale_` or `lost_` if something must be created again.
  bool usable(VkResult result) {
    if (result == VK_SUCCESS) return true;
    if (result == VK_SUBOPTIMAL_KHR) {
      stale_ = true;  // the frame was shown, but the swapchain must be renewed
      return true;
    }
    if (result == VK_ERROR_OUT_OF_DATE_KHR) {
      stale_ = true;
      return false;
    }
    if (result == VK_ERROR_SURFACE_LOST_KHR) {
      lost_ = true;
      return false;
    }
    gpu::check(result, "swapchain");
    return false;
  }

  /// Resizes the shared memory. Returns false if this fails; the next frame then tries again.
  bool fit_shared() {
    wanted_ = pixels_;
    refresh_period_ = period_of(window_);
    extent_ = glm::max(wanted_, ivec2(1));
    stale_ = !shared_->resize(extent_);
    return !stale_;
  }

  void create_surface() {
    destroy_swapchain();
    if (surface_) vkDestroySurfaceKHR(device_.instance, surface_, nullptr);
    surface_ = VK_NULL_HANDLE;
    gpu::check(glfwCreateWindowSurface(device_.instance, window_, nullptr, &surface_), "glfwCreateWindowSurface");
    VkBool32 supported = VK_FALSE;
    gpu::check(vkGetPhysicalDeviceSurfaceSupportKHR(device_.physical, device_.queue_family, surface_, &supported),
               "vkGetPhysicalDeviceSurfaceSupportKHR");
    if (!supported) throw Error("window", device_.name(), "cannot present to this desktop", "a device that presents");
  }

  void create_swapchain() {
    VkSurfaceCapabilitiesKHR caps{};
    const VkResult asked = vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical, surface_, &caps);
    if (!usable(asked)) return;
    const std::uint32_t layers = options_.stereo_surface ? 2 : 1;
    if (layers > caps.maxImageArrayLayers)
      throw Error("window", "layout", fmt::format("a surface of {} layer", caps.maxImageArrayLayers),
                  "two layers, which frame_sequential needs; side_by_side works on any surface");
    wanted_ = pixels_;
    refresh_period_ = period_of(window_);
    VkExtent2D extent = caps.currentExtent;
    if (extent.width == UINT32_MAX)
      extent = {
          std::clamp(static_cast<std::uint32_t>(wanted_.x), caps.minImageExtent.width, caps.maxImageExtent.width),
          std::clamp(static_cast<std::uint32_t>(wanted_.y), caps.minImageExtent.height, caps.maxImageExtent.height)};
    if (extent.width == 0 || extent.height == 0) return;

    // Selects a format without colour conversion, because the bytes are already sRGB.
    std::uint32_t count = 0;
    gpu::check(vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical, surface_, &count, nullptr),
               "vkGetPhysicalDeviceSurfaceFormatsKHR");
    std::vector<VkSurfaceFormatKHR> formats(count);
    gpu::check(vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical, surface_, &count, formats.data()),
               "vkGetPhysicalDeviceSurfaceFormatsKHR");
    const auto good = std::find_if(formats.begin(), formats.end(), [](const VkSurfaceFormatKHR& f) {
      return (f.format == VK_FORMAT_B8G8R8A8_UNORM || f.format == VK_FORMAT_R8G8B8A8_UNORM) &&
             f.colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR;
    });
    if (good == formats.end()) throw Error("window", "", "no 8-bit surface format", "B8G8R8A8 or R8G8B8A8");
    format_ = good->format;

    vkDeviceWaitIdle(device_.device);
    const std::uint32_t images =
        caps.maxImageCount ? std::min(caps.minImageCount + 1, caps.maxImageCount) : caps.minImageCount + 1;
    const VkSwapchainKHR old = swapchain_;
    const VkSwapchainCreateInfoKHR info{.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
                                        .surface = surface_,
                                        .minImageCount = images,
                                        .imageFormat = format_,
                                        .imageColorSpace = good->colorSpace,
                                        .imageExtent = extent,
                                        .imageArrayLayers = layers,
                                        .imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                                        .preTransform = caps.currentTransform,
                                        .compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR,
                                        .presentMode = VK_PRESENT_MODE_FIFO_KHR,
                                        .clipped = VK_TRUE,
                                        .oldSwapchain = old};
    VkSwapchainKHR fresh = VK_NULL_HANDLE;
    const VkResult made = vkCreateSwapchainKHR(device_.device, &info, nullptr, &fresh);
    destroy_swapchain();
    if (!usable(made)) return;
    swapchain_ = fresh;
    extent_ = {static_cast<int>(extent.width), static_cast<int>(extent.height)};
    stale_ = false;

    gpu::check(vkGetSwapchainImagesKHR(device_.device, swapchain_, &count, nullptr), "vkGetSwapchainImagesKHR");
    images_.resize(count);
    drawn_.assign(count, std::uint8_t{0});
    gpu::check(vkGetSwapchainImagesKHR(device_.device, swapchain_, &count, images_.data()), "vkGetSwapchainImagesKHR");
    for (VkImage image : images_) {
      auto& views = views_.emplace_back();
      for (std::uint32_t layer = 0; layer < layers; ++layer) {
        const VkImageViewCreateInfo view{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                         .image = image,
                                         .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                         .format = format_,
                                         .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, layer, 1}};
        gpu::check(vkCreateImageView(device_.device, &view, nullptr, &views.emplace_back()), "vkCreateImageView");
      }
      done_.push_back(create_semaphore());
    }
    // Creates one semaphore more than there are frames in flight.
    for (int i = 0; i < gpu::FrameRing::kSlots + 1; ++i) ready_.push_back(create_semaphore());
    sync_ = 0;
  }

  VkSemaphore create_semaphore() {
    const VkSemaphoreCreateInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    VkSemaphore semaphore = VK_NULL_HANDLE;
    gpu::check(vkCreateSemaphore(device_.device, &info, nullptr, &semaphore), "vkCreateSemaphore");
    return semaphore;
  }

  void destroy_swapchain() {
    vkDeviceWaitIdle(device_.device);
    unshown_ = false;
    for (auto& views : views_)
      for (VkImageView view : views) vkDestroyImageView(device_.device, view, nullptr);
    for (const auto* list : {&ready_, &done_})
      for (VkSemaphore s : *list) vkDestroySemaphore(device_.device, s, nullptr);
    views_.clear();
    ready_.clear();
    done_.clear();
    images_.clear();
    if (swapchain_) vkDestroySwapchainKHR(device_.device, swapchain_, nullptr);
    swapchain_ = VK_NULL_HANDLE;
  }

  void destroy() {
    key_thread_.reset();
    shared_.reset();
    destroy_swapchain();
    if (surface_) vkDestroySurfaceKHR(device_.instance, surface_, nullptr);
    surface_ = VK_NULL_HANDLE;
    if (window_) glfwDestroyWindow(window_);
    window_ = nullptr;
  }

  gpu::Device& device_;
  WindowOptions options_;
  GLFWwindow* window_ = nullptr;
  std::optional<KeyThread> key_thread_;     // reads urgent keys; empty without X11: poll() then reads them
  std::unique_ptr<SharedPicture> shared_;   // if set, it is used instead of Vulkan's swapchain
  std::optional<std::vector<Part>> parts_;  // parts of the last target that changed; nullopt: all
  std::function<void()> finish_;            // composes the last target on the CPU
  VkSurfaceKHR surface_ = VK_NULL_HANDLE;
  VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
  VkFormat format_ = VK_FORMAT_UNDEFINED;
  ivec2 extent_{0}, wanted_{0};
  std::vector<VkImage> images_;
  std::vector<std::uint8_t> drawn_;  // for each swapchain image: true if it contains a frame
  std::vector<std::vector<VkImageView>> views_;
  std::vector<VkSemaphore> ready_, done_;
  std::size_t sync_ = 0;
  std::uint32_t index_ = 0;
  bool stale_ = false, lost_ = false, exposed_ = true;
  bool unshown_ = false;                // the last frame was presented to this object, but is not yet shown
  int polls_ = 0;                       // number of polls since the last target was presented
  UserInput events_;                    // the user's input events since the last poll()
  std::array<ButtonQueue, 3> buttons_;  // for the left, right and middle button
  std::uint64_t events_at_query_ = 0;   // number of desktop events at the last query
  ivec2 pixels_{0}, size_{0};
  dvec2 cursor_{0, 0};
  bool on_screen_ = false, focused_ = false;
  double refresh_period_ = 1.0 / 60;
  Nanos next_ = 0;
};

}  // namespace

std::vector<const char*> window_extensions() {
  ensure_glfw();
  std::uint32_t count = 0;
  const char** names = glfwGetRequiredInstanceExtensions(&count);
  if (!names) throw Error("window", "", "no Vulkan surface on this desktop", "a Vulkan driver that presents");
  return {names, names + count};
}

std::unique_ptr<Output> make_window(gpu::Device& device, const WindowOptions& options) {
  return std::make_unique<Window>(device, options);
}

std::vector<std::string> monitors() {
  ensure_glfw();
  int count = 0;
  GLFWmonitor** all = glfwGetMonitors(&count);
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) {
    const GLFWvidmode* mode = glfwGetVideoMode(all[i]);
    names.push_back(
        fmt::format("{}, {} × {}", glfwGetMonitorName(all[i]), mode ? mode->width : 0, mode ? mode->height : 0));
  }
  return names;
}

}  // namespace typodont::display
