// Shows a window's picture through memory shared with the X server (MIT-SHM). With software rendering, Vulkan would
// send every pixel through a socket: 10 MB per frame for two eyes, written by one side and read by the other. Here only
// the changed parts are copied, once.
#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "engine/display/output.h"

struct GLFWwindow;

namespace typodont::display {

/// A picture in memory that the desktop shares with this process. Render thread only.
class SharedPicture {
 public:
  /// Returns null if the X server is on another machine, if the desktop is not X11, or if its pixels are not 32-bit
  /// BGRA. `composed`: true if the targets are the shared memory itself; false if the device draws into an image.
  static std::unique_ptr<SharedPicture> open(gpu::Device& device, GLFWwindow* window, bool composed);
  virtual ~SharedPicture() = default;

  /// Sets the size in pixels. The old content is lost. Returns false if memory can no longer be shared.
  virtual bool resize(ivec2 size) = 0;
  /// Returns the target to draw into. Its content is kept from frame to frame.
  virtual Target target() = 0;
  /// Shows the finished picture: all of it, or only the given parts. `finish` fills the memory if the picture is
  /// composed on the CPU.
  virtual void show(std::span<const Part> parts, const std::function<void()>& finish) = 0;
  void show_all(const std::function<void()>& finish) { show(std::array{Part{0, 0, size().x, size().y}}, finish); }
  virtual ivec2 size() const = 0;
};

}  // namespace typodont::display
