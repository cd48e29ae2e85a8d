// `typodont experiment` in its own process beside the window. Main thread only.
#pragma once

#include "engine/app/operator/long_work.h"
#include "engine/app/operator/state.h"

namespace typodont {

/// OperatorState::experiment with the selection. Trials go to ~/Typodont/experiments/PERSON/DATE_QUESTION.csv, the
/// result to the .html beside it and to the state.
void make_experiment(OperatorState& s, BackgroundTask& work);

}  // namespace typodont
