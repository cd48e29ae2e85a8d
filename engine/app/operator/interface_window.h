// A desktop window drawn with Dear ImGui: device, output, fonts, theme, input. What is in it is up to the caller, frame
// by frame. Main thread.
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

/// Sizes in pixels at this screen's scale, and the fonts.
struct InterfaceStyle {
  float unit = 16;  // the height of ordinary writing; everything else is a multiple
  ImFont* plain = nullptr;
  ImFont* large = nullptr;  // headings
  ImFont* small = nullptr;
};

class InterfaceWindow {
 public:
  struct Options {
    std::string title = "Typodont";
    display::ivec2 size{1280, 800};
    bool validation = false;
  };
  /// Throws Error where there is no desktop, or no Vulkan device that presents to it.
  explicit InterfaceWindow(const Options& options);
  ~InterfaceWindow();
  InterfaceWindow(const InterfaceWindow&) = delete;
  InterfaceWindow& operator=(const InterfaceWindow&) = delete;

  /// Fonts that hold this language's writing. False where the computer has none for it; then nothing changes.
  bool set_language(session::Language language);
  /// This will be shown too: fonts hold its writing from the next frame on. Between frames.
  void will_show(const std::string& text);

  /// Looks at mouse and keyboard. True when a frame should be drawn: something was done, or `most_seconds` have passed
  /// since the last one.
  bool poll(double most_seconds);
  const display::UserInput& input() const { return input_; }

  /// Between these two, ImGui's calls. end() shows it. `emergency_stop`: that is what Esc and Space are now.
  void begin(bool emergency_stop);
  void end();

  /// A picture for ImGui::Image in this frame. `shows`: another number once one that was drawn anew shows something
  /// else.
  void* texture(const gpu::Image& picture, std::uint64_t shows = 0);
  /// A picture that stays: uploaded once; the caller destroys it after wait_idle().
  gpu::Image upload(const render::Picture& picture);
  void wait_idle();
  /// The device is lost: a new one, in a new window. Pictures that were uploaded are gone; destroy them before.
  void make_anew();

  gpu::Device& device() { return device_; }
  const InterfaceStyle& style() const { return style_; }
  /// The words in the title bar; nothing happens while they stay the same.
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
  std::string more_;  // what will_show() was given and the catalogue does not hold
  Nanos last_frame_ = 0, last_input_ = 0;
  std::uint64_t frames_ = 0, uploads_ = 0;
};

/// True where the computer has a font for the language.
bool can_show(session::Language language);

}  // namespace typodont
