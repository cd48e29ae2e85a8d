// The operator's window, which `typodont` without arguments opens. The user selects an exercise, a hand and a picture,
// runs sessions and sees their results. Main thread.
#pragma once

namespace typodont {

/// Returns when the window is closed. Throws Error without a desktop, and RunFailure if it cannot continue.
void run_operator();

}  // namespace typodont
