// The log of an experiment's trials: a table that is whole after every trial.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/app/experiment/experiment.h"

namespace typodont {

struct TrialLog {
  ExperimentPlan plan;  // as far as a fit needs it: question, models, rule
  std::string scene;    // file, as it was named
  std::string subject;  // name or code of the person; may be empty
  std::vector<AnsweredTrial> answered;
};

/// The whole table. The first lines, which begin with '#', hold the plan.
std::string table_of(const TrialLog& log);
/// Replaces the file by the table. A killed program leaves the table as it was after the trial before.
void write_trial_log(const std::filesystem::path& file, const TrialLog& log);
/// Throws Error naming file, line, column.
TrialLog read_trial_log(const std::filesystem::path& file);

}  // namespace typodont
