// The operator's window: what `typodont` without arguments opens. Chooses an exercise, a hand and a picture, runs
// sessions, shows their results. Main thread.
#pragma once

namespace typodont {

/// Until the window is closed. Throws Error where there is no desktop, RunFailure where it cannot go on.
void run_operator();

}  // namespace typodont
