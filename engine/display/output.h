// Composes the pictures of both eyes into the screen's layout, and shows the result or keeps it in memory. Render
// thread only.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/clock.h"
#include "engine/display/display_rig.h"
#include "engine/display/writing.h"
#include "engine/gpu/resources.h"

namespace typodont::display {

/// Pixels in memory, BGRA, rows `pitch` bytes apart.
struct HostPixels {
  std::uint8_t* first = nullptr;
  std::size_t pitch = 0;
};

/// Where a composed picture is written: in memory or on a screen.
struct Target {
  /// If set, the CPU composes here, and there is no Vulkan image.
  HostPixels memory;
  VkImage image = VK_NULL_HANDLE;
  std::vector<VkImageView> layers;  // one layer, or two of a stereo surface
  ivec2 size{0};
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkImageLayout final_layout = VK_IMAGE_LAYOUT_UNDEFINED;
  VkSemaphore ready = VK_NULL_HANDLE;  // the drawing must wait for this semaphore
  VkSemaphore done = VK_NULL_HANDLE;   // the drawing must signal this semaphore when it has finished
  bool kept = false;                   // true: the target still contains its last frame
};

/// A rectangle of a picture, in pixels.
struct Part {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Composes pictures and text. Pipelines are created when the first target's format is known.
class Compositor {
 public:
  explicit Compositor(gpu::Device& device);
  ~Compositor();
  Compositor(const Compositor&) = delete;
  Compositor& operator=(const Compositor&) = delete;

  /// Texts for both eyes; null: no text. If both eyes share a region, only the first is used.
  using Huds = std::array<const Hud*, 2>;

  /// Shows the pictures on a bent panel, or in a curved mirror, from the next record() on. Empty: both are plane.
  void bend(std::optional<Warp> warp);

  /// Records the composition. `pictures`: one or two layers, layout SHADER_READ_ONLY; `first_row`: for
  /// interleaved rows, the screen's row that shows the target's first row; `changed`: parts changed since the last
  /// record(). Returns the parts drawn; nullopt: all.
  std::optional<std::vector<Part>> record(VkCommandBuffer commands, const gpu::Image& pictures, Layout layout,
                                          const Target& target, int slot, int first_row = 0,
                                          const std::array<std::vector<Part>, 2>* changed = nullptr,
                                          const Huds& huds = {});
  /// Returns true if the text differs from that of the last record() with this layout.
  bool text_changed(const Huds& huds, Layout layout) const;
  /// Composes a target in memory on the CPU; call after the device has finished `slot`.
  void compose(int slot);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Mouse and keyboard input since the last poll.
struct UserInput {
  bool close = false;
  dvec2 pointer{0, 0};  // position of the pointer in the picture, −1..1, y up
  // true: the button is down. At most one event of each button per poll (button_queue.h).
  bool left = false, right = false, middle = false;
  bool shift = false;        // true if the shift key is down
  double wheel = 0;          // steps of the wheel since the last poll
  std::vector<int> pressed;  // keys pressed since the last poll, codes of keys.h

  // Events for a user interface drawn into the picture.
  struct Key {
    int code;
    bool down;
    std::uint32_t typed = 0;  // Unicode code point of typed text; 0: the event is a key
  };
  std::vector<Key> keys;  // events in their order, including releases, repeats and typed text
  dvec2 pixel{-1, -1};    // pixels, pointer's position from the picture's upper left corner
  bool focused = true;

  std::vector<std::string> dropped;  // files dropped onto the window since the last poll
};

class Output {
 public:
  virtual ~Output() = default;
  /// Returns the next target; nullopt: minimised, or the surface is lost for now. Throws RunFailure if it is lost for
  /// good.
  virtual std::optional<Target> acquire() = 0;
  /// Shows the target after its commands were submitted. `drawn`: changed parts; nullopt: all. `finish`: waits until
  /// they are finished, and composes a target in memory; called before the CPU reads the picture.
  virtual void present(const std::optional<std::vector<Part>>& drawn, std::function<void()> finish) = 0;
  virtual ivec2 size() const = 0;
  /// Returns false if nothing of the window is shown, for example if it is minimised.
  virtual bool visible() const { return true; }
  /// Returns true if the window was resized or uncovered, so that it must be composed again.
  virtual bool needs_frame() const { return false; }
  virtual void resize(ivec2) {}
  /// Behaves as if the desktop removed the surface; for tests.
  virtual void lose_surface() {}
  virtual UserInput poll() { return {}; }
  /// Waits for events, at most `most` nanoseconds.
  virtual void wait(Nanos most);
  /// Number of requests of all windows to the desktop.
  virtual std::uint64_t requests() const { return 0; }
  /// Scale of the user interface: 1 on an ordinary screen.
  virtual double scale() const { return 1; }
  virtual int first_row() const { return 0; }
  /// Makes this window receive the keyboard input.
  virtual void take_focus() {}
  /// Sets the text of the window's title bar.
  virtual void set_title(const std::string&) {}
  /// If the window is on the monitor with this number, moves it to the next one and limits its size to that monitor.
  virtual void leave_monitor(int) {}
  /// Time between two screen refreshes, s; 0 if pictures are drawn only into memory.
  virtual double refresh_period() const { return 0; }
  /// Pixels of the last picture, RGBA; empty if pictures are shown in a window.
  virtual std::vector<std::uint8_t> read() { return {}; }
};

/// Returns true if a desktop can show windows.
bool has_desktop();

std::unique_ptr<Output> make_offscreen(gpu::Device& device, ivec2 size);

/// Keys that are handled at once, without waiting for a frame. Codes as in UserInput::pressed.
struct UrgentKeys {
  std::vector<int> codes;
  std::function<void(int code)> pressed;  // must not block
};

#ifdef TYPODONT_WINDOW
struct WindowOptions {
  std::string title = "Typodont";
  ivec2 size{1280, 720};
  int output = -1;              // number of the monitor for full screen; −1: a window
  bool fits_screen = false;     // true: limits the window to the screen's free area
  bool stereo_surface = false;  // true: requests a surface with two layers, for frame-sequential displays
  /// true: a Compositor fills the targets; with software rendering, the targets are in memory.
  bool composed = false;
  double max_frames_per_second = 120;  // Hz, limits the frame rate if presenting does not wait
  /// Keys handled immediately: with X11, a thread of the window calls `pressed`; otherwise poll() does.
  UrgentKeys urgent;
};
/// Vulkan extensions for Device::create. Throws Error without a desktop.
std::vector<const char*> window_extensions();
/// Opens a window. Throws Error.
std::unique_ptr<Output> make_window(gpu::Device& device, const WindowOptions& options);
/// Monitors in the order of WindowOptions::output: "DP-1, 1920 × 1080". Throws Error without a desktop.
std::vector<std::string> monitors();
#endif

}  // namespace typodont::display
