// Runs an experiment in a process of its own (`typodont experiment`) beside the window. Main thread.
#pragma once

#include "engine/app/operator/long_work.h"
#include "engine/app/operator/state.h"

namespace typodont {

/// Runs the experiment in OperatorState::experiment with the selected exercise, hand, picture and person. It writes the
/// trials and the result to ~/Typodont/experiments/PERSON/DATE_QUESTION.csv and .html, and the state's finding.
void make_experiment(OperatorState& s, BackgroundTask& work);

}  // namespace typodont
