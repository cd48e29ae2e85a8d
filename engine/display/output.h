// Where a finished frame goes: a picture in memory, or a window. Both eyes' pictures are composed into the layout of
// the screen and shown. Render thread.
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

/// A picture in the host's memory: BGRA bytes, rows `pitch` bytes apart.
struct HostPixels {
  std::uint8_t* first = nullptr;
  std::size_t pitch = 0;
};

/// What the composed frame is drawn into.
struct Target {
  HostPixels memory;  // where it is set there is no image: the processor composes, once the eyes are drawn
  VkImage image = VK_NULL_HANDLE;
  std::vector<VkImageView> layers;  // one, or two where the surface is stereo itself
  ivec2 size{0};
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkImageLayout final_layout = VK_IMAGE_LAYOUT_UNDEFINED;
  VkSemaphore ready = VK_NULL_HANDLE;  // wait for it before drawing
  VkSemaphore done = VK_NULL_HANDLE;   // signal it after drawing
  bool kept = false;                   // what was last composed into this image is still there
};

/// Pixels of a picture.
struct Part {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Composes the eyes by layout. Creates its pipeline for the first target.
class Compositor {
 public:
  explicit Compositor(gpu::Device& device);
  ~Compositor();
  Compositor(const Compositor&) = delete;
  Compositor& operator=(const Compositor&) = delete;

  /// What is written over each eye's picture; null: nothing. One picture, or eyes that share every place: the first.
  using Huds = std::array<const Hud*, 2>;

  /// `pictures`: two layers or one, in SHADER_READ_ONLY layout. `first_row`: where the target begins on the panel, so
  /// that the rows of a row-interleaved panel keep their eye wherever the window stands. `changed`: what of each eye's
  /// picture is new since the last record(); a target that kept an earlier frame gets no more than it lacks. Returns
  /// the parts of the target that are drawn; nothing: all of it.
  std::optional<std::vector<Part>> record(VkCommandBuffer commands, const gpu::Image& pictures, Layout layout,
                                          const Target& target, int slot, int first_row = 0,
                                          const std::array<std::vector<Part>, 2>* changed = nullptr,
                                          const Huds& huds = {});
  /// True when the writing says something else than in the last record(), which had this layout.
  bool says_new(const Huds& huds, Layout layout) const;
  /// Where the target is memory: fills it, once the device has done what was recorded for the slot.
  void compose(int slot);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What the user did with mouse and keyboard since the last poll.
struct UserInput {
  bool close = false;
  dvec2 pointer{0, 0};                               // −1..1 over the picture, y up
  bool left = false, right = false, middle = false;  // down, or pressed and let go since the last poll
  bool shift = false;                                // a key that is held
  double wheel = 0;                                  // steps since the last poll
  std::vector<int> pressed;                          // keys pressed since the last poll, upper-case ASCII or GLFW codes

  // For a user interface drawn into the picture.
  struct Key {
    int code;
    bool down;
    std::uint32_t typed = 0;  // a code point that was written, and then no key
  };
  std::vector<Key> keys;          // in their order, releases, repeats and writing too
  std::array<bool, 3> clicked{};  // left, right, middle: went down since the last poll
  dvec2 pixel{-1, -1};            // of the pointer, from the picture's upper left
  bool focused = true;

  std::vector<std::string> dropped;  // files and folders that were let fall on the window since the last poll
};

class Output {
 public:
  virtual ~Output() = default;
  /// The next target, or nothing: minimised, or lost for the moment. Throws RunFailure when it is lost for good.
  virtual std::optional<Target> acquire() = 0;
  /// Shows what was drawn into the last target: all of it, or these parts of it; call after submitting. Where the
  /// target is memory `finish` waits for the device and composes; it is called when it is time to show it.
  virtual void present(const std::optional<std::vector<Part>>& drawn = std::nullopt,
                       std::function<void()> finish = {}) = 0;
  virtual ivec2 size() const = 0;
  /// Whether anybody could see a picture there: not in a window that is minimised.
  virtual bool visible() const { return true; }
  /// The screen lost what it showed (resized, uncovered): compose again although nothing moved.
  virtual bool needs_frame() const { return false; }
  virtual void resize(ivec2) {}
  /// As if the desktop had taken the surface away: for tests of what then happens.
  virtual void lose_surface() {}
  virtual UserInput poll() { return {}; }
  /// Until the user or the desktop does something, or for so long.
  virtual void wait(Nanos most);
  /// What the desktop was asked or told so far, by all windows of the program.
  virtual std::uint64_t requests() const { return 0; }
  /// How large writing should be drawn here, 1: on an ordinary screen.
  virtual double scale() const { return 1; }
  virtual int first_row() const { return 0; }
  /// The keyboard is this window's from now on.
  virtual void take_focus() {}
  /// The words in the window's title bar.
  virtual void set_title(const std::string&) {}
  /// Another window fills this monitor: this one moves to the next, where there is one, and becomes no larger than
  /// that.
  virtual void leave_monitor(int) {}
  /// s between two pictures of the screen; 0 for a picture in memory.
  virtual double refresh_period() const { return 0; }
  /// Reads the composed picture back; RGBA bytes. Only a picture in memory can.
  virtual std::vector<std::uint8_t> read() { return {}; }
};

/// Whether there is a desktop to open a window on.
bool has_desktop();

std::unique_ptr<Output> make_offscreen(gpu::Device& device, ivec2 size);

#ifdef TYPODONT_WINDOW
struct WindowOptions {
  std::string title = "Typodont";
  ivec2 size{1280, 720};
  int output = -1;                      // full screen on this monitor; −1: a window
  bool fits_screen = false;             // a window is made no larger than the screen has room for
  bool stereo_surface = false;          // two layers, for frame-sequential displays
  bool composed = false;                // a Compositor fills it: where a processor draws, its targets are memory
  double most_frames_per_second = 120;  // where presenting does not wait for the screen
};
/// What Device::create needs for a window. Throws Error where there is no desktop to open one on.
std::vector<const char*> window_extensions();
/// Throws Error. Survives resizing, minimising and a lost surface.
std::unique_ptr<Output> make_window(gpu::Device& device, const WindowOptions& options);
/// The screens connected, in the order of WindowOptions::output: "DP-1, 1920 × 1080". Throws Error where there is no
/// desktop.
std::vector<std::string> monitors();
#endif

}  // namespace typodont::display
