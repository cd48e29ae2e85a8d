// Events from the desktop. A query of the desktop needs a round trip to another process, so it is made only after the
// desktop reported a change. All windows of the program share the connection. Drawing thread only.
#pragma once

#include <cstdint>

#include "engine/base/clock.h"

struct _XDisplay;

namespace typodont::display {

/// Connection to the X server of GLFW's windows; null on another desktop.
_XDisplay* x_server();

/// Sends the windows all desktop events since the last call. The returned number changes whenever there were any; where
/// this cannot be detected, it always changes.
std::uint64_t take_desktop_events();

/// Waits until the desktop sends an event, at most `most`.
void wait_for_desktop(Nanos most);

/// Number of requests sent to the X server so far, with or without an answer.
std::uint64_t desktop_requests();

}  // namespace typodont::display
