// A desktop window that Dear ImGui draws: GPU device, output, fonts, theme and input. The caller draws the content of
// each frame. Main thread only.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/app/operator/draw_list_painter.h"
#include "engine/app/operator/key_queue.h"
#include "engine/base/clock.h"
#include "engine/display/output.h"
#include "engine/gpu/device.h"
#include "engine/render/picture.h"
#include "engine/session/strings.h"

struct ImFont;

namespace typodont {

/// Sizes in pixels and fonts, for the scale of this screen.
struct InterfaceStyle {
  float unit = 16;  // pixels, height of normal text; all other sizes are multiples of this height
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
  };
  /// Opens the window. Throws Error if there is no desktop, or no Vulkan device that can draw to it.
  explicit InterfaceWindow(const Options& options);
  ~InterfaceWindow();
  InterfaceWindow(const InterfaceWindow&) = delete;
  InterfaceWindow& operator=(const InterfaceWindow&) = delete;

  /// Loads fonts for this language. If the computer has no such font, changes nothing and returns false.
  bool set_language(session::Language language);
  /// Adds the characters of `text` to the fonts from the next frame on. Call it between two frames.
  void announce_text(const std::string& text);

  /// Reads mouse and keyboard. Returns true if a frame should be drawn, because input has arrived or because the last
  /// frame is older than `most_seconds`.
  bool poll(double most_seconds);
  const display::UserInput& input() const { return input_; }

  /// Begins a frame, which end() shows. Call ImGui's functions between begin() and end(). `emergency_stop`: true if the
  /// keys Esc and Space act as emergency stop in this frame.
  void begin(bool emergency_stop);
  void end();

  /// Registers a picture as a texture that ImGui::Image draws in this frame. `shows`: a number that changes whenever
  /// the picture's content changes.
  void* texture(const gpu::Image& picture, std::uint64_t shows = 0);
  /// Uploads a picture that is shown in several frames. The caller destroys it after wait_idle().
  gpu::Image upload(const render::Picture& picture);
  void wait_idle();
  /// Creates a new GPU device and a new window after the device was lost. Uploaded pictures are lost too, so destroy
  /// them before this call.
  void recreate_device();

  gpu::Device& device() { return device_; }
  const InterfaceStyle& style() const { return style_; }
  /// Sets the text of the title bar if it differs from the present text.
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
  std::string more_;  // characters that announce_text() added to those of the catalogue
  Nanos last_frame_ = 0, last_input_ = 0;
  std::uint64_t frames_ = 0, uploads_ = 0;
};

/// Returns true if the computer has a font for the language.
bool can_show(session::Language language);

}  // namespace typodont
