// Runs `typodont experiment` in a separate process beside the window. Main thread only.
#pragma once

#include "engine/app/operator/long_work.h"
#include "engine/app/operator/state.h"

namespace typodont {

/// Runs the experiment of OperatorState::experiment with the selected exercise and hand. Writes the trials to
/// ~/Typodont/experiments/PERSON/DATE_QUESTION.csv, the result to the .html file beside it and to the state.
void make_experiment(OperatorState& s, BackgroundTask& work);

}  // namespace typodont
