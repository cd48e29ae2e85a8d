// A desktop window with Dear ImGui: GPU device, output, fonts, theme, input. The caller draws the content. Main thread
// only.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/app/operator/draw_list_painter.h"
#include "engine/app/operator/key_queue.h"
#include "engine/base/clock.h"
#include "engine/display/output.h"
#include "engine/gpu/device.h"
#include "engine/render/picture.h"
#include "engine/session/strings.h"

struct ImFont;

namespace typodont {

/// Sizes and fonts for the scale of this screen.
struct InterfaceStyle {
  float unit = 16;  // pixels, height of normal text, the unit of all sizes
  ImFont* plain = nullptr;
  ImFont* large = nullptr;  // font for headings
  ImFont* small = nullptr;
};

class InterfaceWindow {
 public:
  struct Options {
    std::string title = "Typodont";
    display::ivec2 size{1280, 800};
    bool validation = false;
    display::UrgentKeys urgent{};
  };
  /// Opens the window. Throws Error if there is no desktop, or no Vulkan device that can draw to it.
  explicit InterfaceWindow(const Options& options);
  ~InterfaceWindow();
  InterfaceWindow(const InterfaceWindow&) = delete;
  InterfaceWindow& operator=(const InterfaceWindow&) = delete;

  /// Sets the language. False: there is no font for it, and nothing changes.
  bool set_language(session::Language language);
  /// Makes sure that the font contains all characters of `text`. Call between frames only.
  void announce_text(const std::string& text);

  /// Reads mouse and keyboard. True: a frame must be drawn, because of input or because `max_seconds` have passed.
  bool poll(double max_seconds);
  const display::UserInput& input() const { return input_; }

  /// Call ImGui's functions between begin() and end(). `emergency_stop`: in this frame, Esc and Space stop the session.
  void begin(bool emergency_stop);
  /// `shown`: false for a frame that only takes input, because the GPU is busy for long.
  void end(bool shown = true);

  /// Makes a picture available to ImGui::Image in this frame. `shows`: a number that changes with the content, needed
  /// only if the content changes without an upload.
  void* texture(const gpu::Image& picture, std::uint64_t shows = 0);
  /// Uploads a picture. The caller destroys it after wait_idle().
  gpu::Image upload(const render::Picture& picture);
  /// Destroys the uploaded pictures in `images`, and uploads others.
  void replace(std::vector<gpu::Image>& images, std::span<const render::Picture> pictures);
  void wait_idle();
  /// Creates GPU device and window again after the device was lost. Destroy uploaded pictures first.
  void recreate_device();

  gpu::Device& device() { return device_; }
  const InterfaceStyle& style() const { return style_; }
  /// Sets the title if it differs from the current one.
  void set_title(const std::string& title);
  display::ivec2 size() const { return output_->size(); }
  display::Output& output() { return *output_; }
  std::uint64_t frames() const { return frames_; }

 private:
  void open();
  void close();
  void build_fonts();

  Options options_;
  gpu::Device device_;
  gpu::FrameRing ring_;
  std::unique_ptr<display::Output> output_;
  std::unique_ptr<DrawListPainter> painter_;
  InterfaceStyle style_;
  session::Language language_ = session::Language::kEnglish;
  double scale_ = 1;
  display::UserInput input_;
  KeyQueue keys_;
  std::string more_;  // characters from announce_text() that the text catalogue does not contain
  Nanos last_frame_ = 0, last_input_ = 0;
  std::uint64_t frames_ = 0, uploads_ = 0;
};

/// True if there is a font for the language.
bool can_show(session::Language language);

}  // namespace typodont
