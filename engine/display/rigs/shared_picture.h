// MIT-SHM: changed parts are copied once, instead of 10 MB a frame through a socket.
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
  /// Null: another machine, no X11, or not 32-bit BGRA. `composed`: targets are the shared memory, else an image.
  static std::unique_ptr<SharedPicture> open(gpu::Device& device, GLFWwindow* window, bool composed);
  virtual ~SharedPicture() = default;

  /// Pixels; content is lost. False: no longer shareable.
  virtual bool resize(ivec2 size) = 0;
  /// Content is kept.
  virtual Target target() = 0;
  /// All or parts. `finish` composes on the CPU.
  virtual void show(std::span<const Part> parts, const std::function<void()>& finish) = 0;
  void show_all(const std::function<void()>& finish) { show(std::array{Part{0, 0, size().x, size().y}}, finish); }
  virtual ivec2 size() const = 0;
};

}  // namespace typodont::display
