#include "engine/display/rigs/desktop_events.h"

#include <GLFW/glfw3.h>
#include <poll.h>

#include <chrono>
#include <thread>

#include "engine/base/error.h"
#include "engine/base/late_library.h"
// Included last: Xlib defines the macros None, Bool and Status.
#include <X11/Xlib.h>

namespace typodont::display {

namespace {

constinit LateLibrary glfw{TYPODONT_LATE_GLFW}, glfw_x11{TYPODONT_LATE_GLFW}, x11{TYPODONT_LATE_X11};
TYPODONT_LATE(glfw, glfwPollEvents)
const Late<::Display*()> glfwGetX11Display{glfw_x11, "glfwGetX11Display"};
const Late<::Window(GLFWwindow*)> glfwGetX11Window{glfw_x11, "glfwGetX11Window"};
TYPODONT_LATE(x11, XPending)

/// False if GLFW was built without X11.
bool glfw_has_x11() {
  static const bool has = [] {
    try {
      glfw_x11.load();
    } catch (const Error&) {
      return false;
    }
    return true;
  }();
  return has;
}

}  // namespace

_XDisplay* x_server() {
  return glfw_has_x11() ? glfwGetX11Display() : nullptr;
}

std::string x_server_name() {
  return DisplayString(x_server());
}

unsigned long x_window(GLFWwindow* window) {
  return x_server() ? glfwGetX11Window(window) : 0;
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
