// The window that `typodont` opens without arguments: select an exercise, run sessions, read results. Main thread only.
#pragma once

namespace typodont {

/// Runs the window until it is closed. Throws Error if there is no desktop, RunFailure if it cannot continue.
void run_operator();

}  // namespace typodont
