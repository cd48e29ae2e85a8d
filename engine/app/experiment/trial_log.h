// Stores the trials of an experiment as a table, which is rewritten after each trial.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/app/experiment/experiment.h"

namespace typodont {

struct TrialLog {
  ExperimentPlan plan;  // only the members question, models and rule
  std::string scene;    // name of the scene as the user wrote it
  std::string subject;  // name or code of the subject; may be empty
  std::vector<AnsweredTrial> answered;
};

/// The log as a table. Its first lines begin with '#' and contain the plan.
std::string table_of(const TrialLog& log);
/// Writes the log. If the program is killed while it writes, the table of the last trial remains.
void write_trial_log(const std::filesystem::path& file, const TrialLog& log);
/// Reads a log. Throws Error with file, line and column.
TrialLog read_trial_log(const std::filesystem::path& file);

}  // namespace typodont
