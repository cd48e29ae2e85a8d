// Events and queries of the desktop. A query needs a round trip to the server, so it is made only after events. All
// windows share one connection. Render thread only.
#pragma once

#include <cstdint>
#include <string>

#include "engine/base/clock.h"

struct _XDisplay;
struct GLFWwindow;

namespace typodont::display {

/// Connection to the X server; null: there is none.
_XDisplay* x_server();

/// Name of the server as in the variable DISPLAY. Only with an X server.
std::string x_server_name();
/// Number of a window on the X server; 0: no X server.
unsigned long x_window(GLFWwindow* window);

/// Handles events of all windows. Returns a number that changes after events; without X11, it changes at every call.
std::uint64_t take_desktop_events();

/// Waits for events, at most `most` nanoseconds.
void wait_for_desktop(Nanos most);

/// Number of requests to the X server so far, with or without an answer.
std::uint64_t desktop_requests();

}  // namespace typodont::display
