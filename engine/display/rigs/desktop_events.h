// Queries need a round trip, so only after events. One connection for all windows. Render thread.
#pragma once

#include <cstdint>

#include "engine/base/clock.h"

struct _XDisplay;

namespace typodont::display {

/// Null: no X server.
_XDisplay* x_server();

/// To the windows. The number changes with events; without X11 always.
std::uint64_t take_desktop_events();

/// At most `most` (ns).
void wait_for_desktop(Nanos most);

/// With or without an answer.
std::uint64_t desktop_requests();

}  // namespace typodont::display
