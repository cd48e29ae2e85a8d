// The output of finished frames: a picture in memory, or a window. It composes both eyes' pictures into the screen's
// layout and shows them. Render thread only.
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

/// A picture in host memory: BGRA bytes, with rows `pitch` bytes apart.
struct HostPixels {
  std::uint8_t* first = nullptr;
  std::size_t pitch = 0;
};

/// The picture, in memory or on a screen, into which a frame is composed.
struct Target {
  /// if set, there is no Vulkan image: the CPU composes into this memory after the eyes' pictures are drawn
  HostPixels memory;
  VkImage image = VK_NULL_HANDLE;
  std::vector<VkImageView> layers;  // views of the target's image: one, or two if the surface itself is stereo
  ivec2 size{0};
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkImageLayout final_layout = VK_IMAGE_LAYOUT_UNDEFINED;
  VkSemaphore ready = VK_NULL_HANDLE;  // the drawing must wait for this semaphore
  VkSemaphore done = VK_NULL_HANDLE;   // the drawing must signal this semaphore when it has finished
  bool kept = false;                   // true if the image still contains the frame that was last composed into it
};

/// A rectangle of a picture, in pixels.
struct Part {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Composes the eyes' pictures in the screen's layout. Creates its pipeline at the first target.
class Compositor {
 public:
  explicit Compositor(gpu::Device& device);
  ~Compositor();
  Compositor(const Compositor&) = delete;
  Compositor& operator=(const Compositor&) = delete;

  /// Text over each eye's picture; null: no text. If there is only one picture, or if both eyes' pictures share all
  /// regions of the target, only the first entry is used.
  using Huds = std::array<const Hud*, 2>;

  /// Records the commands that compose the pictures in the target. `pictures`: two layers or one, in SHADER_READ_ONLY
  /// layout. `first_row`: row of the panel at which the target begins, so that a row-interleaved panel shows the
  /// correct eye at every window position. `changed`: the parts of each eye's picture that are new since the last
  /// record(). If the target contains an earlier frame, only the parts that changed since then are drawn. Returns the
  /// parts of the target that are drawn; no value: everything.
  std::optional<std::vector<Part>> record(VkCommandBuffer commands, const gpu::Image& pictures, Layout layout,
                                          const Target& target, int slot, int first_row = 0,
                                          const std::array<std::vector<Part>, 2>* changed = nullptr,
                                          const Huds& huds = {});
  /// Returns true if the text differs from the text of the last record() with the same layout.
  bool text_changed(const Huds& huds, Layout layout) const;
  /// Composes a target in memory after the device has finished the commands of the frame in flight `slot`.
  void compose(int slot);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Mouse and keyboard input since the last poll.
struct UserInput {
  bool close = false;
  dvec2 pointer{0, 0};  // position of the pointer in the picture, −1..1, y up
  // mouse buttons; true: down. Each poll shows at most one press or release of each button (button_queue.h).
  bool left = false, right = false, middle = false;
  bool shift = false;        // true if the shift key is down
  double wheel = 0;          // steps of the wheel since the last poll
  std::vector<int> pressed;  // keys pressed since the last poll, upper-case ASCII or GLFW codes

  // A keyboard event for a user interface that is drawn into the picture.
  struct Key {
    int code;
    bool down;
    std::uint32_t typed = 0;  // code point of typed text; 0: the entry is a key
  };
  std::vector<Key> keys;  // events in their order, including releases, repeats and typed text
  dvec2 pixel{-1, -1};    // pixels, position of the pointer from the picture's upper left corner
  bool focused = true;

  std::vector<std::string> dropped;  // files and folders that the user dropped on the window since the last poll
};

class Output {
 public:
  virtual ~Output() = default;
  /// Returns the next target; no value if the window is minimised or the surface is temporarily lost. Throws RunFailure
  /// if the surface is permanently lost.
  virtual std::optional<Target> acquire() = 0;
  /// Shows the last target: all of it, or only the given parts. Call it after the commands were submitted. If the
  /// target is memory, `finish` is called immediately before the picture is shown. `finish` waits for the device and
  /// composes the picture.
  virtual void present(const std::optional<std::vector<Part>>& drawn = std::nullopt,
                       std::function<void()> finish = {}) = 0;
  virtual ivec2 size() const = 0;
  /// Returns false if the picture is not visible to anybody, for example in a minimised window.
  virtual bool visible() const { return true; }
  /// Returns true if the window has lost its content, because it was resized or uncovered. Then the frame must be
  /// composed again even if nothing moved.
  virtual bool needs_frame() const { return false; }
  virtual void resize(ivec2) {}
  /// Lets the surface fail as if the desktop had removed it. Only for tests.
  virtual void lose_surface() {}
  virtual UserInput poll() { return {}; }
  /// Waits until an event from the user or the desktop arrives, but at most for the time `most` (ns).
  virtual void wait(Nanos most);
  /// Returns the number of requests that all windows of the program have sent to the desktop so far.
  virtual std::uint64_t requests() const { return 0; }
  /// Returns the scale factor for text, which is 1 on an ordinary screen.
  virtual double scale() const { return 1; }
  virtual int first_row() const { return 0; }
  /// Makes this window receive the keyboard input.
  virtual void take_focus() {}
  /// Sets the text of the window's title bar.
  virtual void set_title(const std::string&) {}
  /// Moves this window to the next monitor, if there is one, and limits the window's size to that monitor. Must be
  /// called if another window covers this monitor.
  virtual void leave_monitor(int) {}
  /// Returns the time (s) between two refreshes of the screen; 0 for a picture in memory.
  virtual double refresh_period() const { return 0; }
  /// Reads the composed picture back as RGBA bytes. Only for a picture in memory.
  virtual std::vector<std::uint8_t> read() { return {}; }
};

/// Returns true if there is a desktop on which a window can be opened.
bool has_desktop();

std::unique_ptr<Output> make_offscreen(gpu::Device& device, ivec2 size);

#ifdef TYPODONT_WINDOW
struct WindowOptions {
  std::string title = "Typodont";
  ivec2 size{1280, 720};
  int output = -1;              // number of the monitor for full screen; −1: a window
  bool fits_screen = false;     // true: the window's size is limited to the screen's free area
  bool stereo_surface = false;  // true: requests a surface with two layers, for frame-sequential displays
  /// true: a Compositor fills the targets; with software rendering, the targets are in memory
  bool composed = false;
  double most_frames_per_second = 120;  // Hz, largest frame rate if presenting does not wait for the screen
};
/// Returns the Vulkan extensions that Device::create needs for a window. Throws Error if there is no desktop.
std::vector<const char*> window_extensions();
/// Opens a window, which handles resizing, minimising and a lost surface. Throws Error.
std::unique_ptr<Output> make_window(gpu::Device& device, const WindowOptions& options);
/// Returns the connected screens, in the order of WindowOptions::output, for example "DP-1, 1920 × 1080". Throws Error
/// if there is no desktop.
std::vector<std::string> monitors();
#endif

}  // namespace typodont::display
