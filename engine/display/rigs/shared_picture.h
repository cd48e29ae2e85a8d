// Shows pictures in memory shared with the X server (MIT-SHM): changed parts are copied once, instead of 10 MB per
// frame through a socket.
#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "engine/display/output.h"

struct GLFWwindow;

namespace typodont::display {

/// A window's picture in shared memory. Render thread only.
class SharedPicture {
 public:
  /// Returns null if the server is on another computer, is not X11, or does not use 32-bit BGRA. `composed`:
  /// pictures are drawn directly in the shared memory; false: in a Vulkan image that is copied.
  static std::unique_ptr<SharedPicture> open(gpu::Device& device, GLFWwindow* window, bool composed);
  virtual ~SharedPicture() = default;

  /// Changes the size in pixels; the content is lost. Returns false if the memory can no longer be shared.
  virtual bool resize(ivec2 size) = 0;
  /// Target for the next picture; keeps its content.
  virtual Target target() = 0;
  /// Shows the parts of the picture. `finish`: is called first, as in Output::present().
  virtual void show(std::span<const Part> parts, const std::function<void()>& finish) = 0;
  void show_all(const std::function<void()>& finish) { show(std::array{Part{0, 0, size().x, size().y}}, finish); }
  virtual ivec2 size() const = 0;
};

}  // namespace typodont::display
