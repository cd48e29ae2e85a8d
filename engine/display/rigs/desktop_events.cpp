#include "engine/display/rigs/desktop_events.h"

#include <GLFW/glfw3.h>
#include <dlfcn.h>
#include <poll.h>
// Included last: Xlib defines the macros None, Bool and Status.
#include <X11/Xlib.h>

#include <chrono>
#include <thread>

namespace typodont::display {

_XDisplay* x_server() {
  // GLFW lacks this function if it was built without X11.
  static const auto display_of = reinterpret_cast<::Display* (*)()>(::dlsym(RTLD_DEFAULT, "glfwGetX11Display"));
  return display_of ? display_of() : nullptr;
}

std::string x_server_name() {
  return DisplayString(x_server());
}

unsigned long x_window(GLFWwindow* window) {
  static const auto window_of = reinterpret_cast<::Window (*)(GLFWwindow*)>(::dlsym(RTLD_DEFAULT, "glfwGetX11Window"));
  return window_of && x_server() ? window_of(window) : 0;
}

std::uint64_t take_desktop_events() {
  static std::uint64_t news = 0;
  ::Display* const server = x_server();
  if (server && XPending(server) == 0) return news;
  glfwPollEvents();
  return ++news;
}

void wait_for_desktop(Nanos most) {
  ::Display* const server = x_server();
  if (!server) return std::this_thread::sleep_for(std::chrono::nanoseconds(most));
  if (XPending(server) > 0) return;
  pollfd link{ConnectionNumber(server), POLLIN, 0};
  const timespec patience{most / kNanosPerSecond, most % kNanosPerSecond};
  ::ppoll(&link, 1, &patience, nullptr);
}

std::uint64_t desktop_requests() {
  ::Display* const server = x_server();
  return server ? NextRequest(server) : 0;
}

}  // namespace typodont::display
