// Queries need a round trip, so only after events. One connection for all windows. Render thread.
#pragma once

#include <cstdint>
#include <string>

#include "engine/base/clock.h"

struct _XDisplay;
struct GLFWwindow;

namespace typodont::display {

/// Null: no X server.
_XDisplay* x_server();

/// As in DISPLAY. Only with an X server.
std::string x_server_name();
/// X11's number of a window; 0: no X server.
unsigned long x_window(GLFWwindow* window);

/// To the windows. The number changes with events; without X11 always.
std::uint64_t take_desktop_events();

/// At most `most` (ns).
void wait_for_desktop(Nanos most);

/// With or without an answer.
std::uint64_t desktop_requests();

}  // namespace typodont::display
