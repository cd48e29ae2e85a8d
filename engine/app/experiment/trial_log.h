// The log of an experiment's trials: a table in a file. The file is rewritten completely after every trial.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/app/experiment/experiment.h"

namespace typodont {

struct TrialLog {
  ExperimentPlan plan;  // the experiment's plan; contains only the members that a fit needs: question, models, rule
  std::string scene;    // name of the scene file as the user wrote it
  std::string subject;  // name or code of the person; may be empty
  std::vector<AnsweredTrial> answered;
};

/// Returns the whole table as text. The first lines begin with '#' and contain the plan.
std::string table_of(const TrialLog& log);
/// Writes the table to the file. If the program is killed while writing, the file still contains the table of the
/// previous trial.
void write_trial_log(const std::filesystem::path& file, const TrialLog& log);
/// Reads a log. Throws Error that names file, line and column.
TrialLog read_trial_log(const std::filesystem::path& file);

}  // namespace typodont
