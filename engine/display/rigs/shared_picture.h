// A window's picture handed to the desktop through memory that both see (X11, MIT-SHM). Where a processor draws, Vulkan
// presents by sending every pixel through a socket: 10 MB a frame for two eyes, written by one side and read by the
// other. Here only the parts that changed are copied, once.
#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "engine/display/output.h"

struct GLFWwindow;

namespace typodont::display {

/// Render thread.
class SharedPicture {
 public:
  /// Null where the desktop is on another machine, is not X11, or shows other pixels than BGRA in 32 bits.
  /// `composed`: its targets are that memory itself; otherwise an image the device draws into.
  static std::unique_ptr<SharedPicture> open(gpu::Device& device, GLFWwindow* window, bool composed);
  virtual ~SharedPicture() = default;

  /// Pixels. What it held is gone. False: there is no memory to share any more.
  virtual bool resize(ivec2 size) = 0;
  /// To draw into. It keeps what it holds from frame to frame.
  virtual Target target() = 0;
  /// Shows what was drawn, once it is: all of it, or these parts. `finish` fills the memory, where it is composed.
  virtual void show(std::span<const Part> parts, const std::function<void()>& finish) = 0;
  void show_all(const std::function<void()>& finish) { show(std::array{Part{0, 0, size().x, size().y}}, finish); }
  virtual ivec2 size() const = 0;
};

}  // namespace typodont::display
