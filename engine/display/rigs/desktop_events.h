// What the desktop has to say: asking it anything takes a round trip to another process, so it is asked only after it
// said that something changed. All windows of the program share the connection. Drawing thread only.
#pragma once

#include <cstdint>

#include "engine/base/clock.h"

struct _XDisplay;

namespace typodont::display {

/// The X server that GLFW's windows are on; null where the desktop is another one.
_XDisplay* x_server();

/// Has the windows told what the desktop sent since the last call. The number changes whenever that was anything; where
/// it cannot be seen, always.
std::uint64_t take_desktop_events();

/// Until the desktop sends something, or for so long.
void wait_for_desktop(Nanos most);

/// Requests made of the X server so far, with or without an answer.
std::uint64_t desktop_requests();

}  // namespace typodont::display
