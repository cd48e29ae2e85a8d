// The window of `typodont` without arguments: select, run sessions, read results. Main thread only.
#pragma once

namespace typodont {

/// Until it is closed. Throws Error without a desktop, RunFailure if it cannot continue.
void run_operator();

}  // namespace typodont
