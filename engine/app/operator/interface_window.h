// A desktop window of Dear ImGui: device, output, fonts, theme, input. The caller draws the content. Main thread only.
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

/// For this screen's scale.
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
  /// Throws Error without desktop, or a Vulkan device that can draw to it.
  explicit InterfaceWindow(const Options& options);
  ~InterfaceWindow();
  InterfaceWindow(const InterfaceWindow&) = delete;
  InterfaceWindow& operator=(const InterfaceWindow&) = delete;

  /// False, and no change, without a font for it.
  bool set_language(session::Language language);
  /// Characters for the next frames. Between frames only.
  void announce_text(const std::string& text);

  /// Mouse and keyboard. True: draw a frame, because of input or after `most_seconds`.
  bool poll(double most_seconds);
  const display::UserInput& input() const { return input_; }

  /// ImGui's functions go between begin() and end(). `emergency_stop`: Esc and Space act as such in this frame.
  void begin(bool emergency_stop);
  void end();

  /// For ImGui::Image in this frame. `shows` changes with the content.
  void* texture(const gpu::Image& picture, std::uint64_t shows = 0);
  /// For several frames. The caller destroys it after wait_idle().
  gpu::Image upload(const render::Picture& picture);
  void wait_idle();
  /// New device and window after a loss. Destroy uploaded pictures first.
  void recreate_device();

  gpu::Device& device() { return device_; }
  const InterfaceStyle& style() const { return style_; }
  /// If it differs.
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
  std::string more_;  // from announce_text(), beyond the catalogue
  Nanos last_frame_ = 0, last_input_ = 0;
  std::uint64_t frames_ = 0, uploads_ = 0;
};

/// A font for the language is there.
bool can_show(session::Language language);

}  // namespace typodont
