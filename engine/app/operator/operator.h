// The operator's window, which `typodont` without arguments opens. The user selects an exercise, a hand and a picture,
// runs sessions and reads their results. Main thread only.
#pragma once

namespace typodont {

/// Runs the window until the user closes it. Throws Error if there is no desktop, and RunFailure if the program cannot
/// continue.
void run_operator();

}  // namespace typodont
