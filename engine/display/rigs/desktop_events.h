// Events from the desktop. A query of the desktop needs a round trip to another process. Therefore the program queries
// only after the desktop has reported a change. All windows of the program share one connection to the desktop. Render
// thread only.
#pragma once

#include <cstdint>

#include "engine/base/clock.h"

struct _XDisplay;

namespace typodont::display {

/// Returns the connection of GLFW's windows to the X server; null on another desktop.
_XDisplay* x_server();

/// Delivers all desktop events since the last call to the windows. Returns a number that changes if events were
/// delivered. If the desktop is not X11, the number changes in every call.
std::uint64_t take_desktop_events();

/// Waits until the desktop sends an event, but at most for the time `most` (ns).
void wait_for_desktop(Nanos most);

/// Returns the number of requests sent to the X server so far, with or without an answer.
std::uint64_t desktop_requests();

}  // namespace typodont::display
