// The trials as a table. The file is rewritten after every trial.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/app/experiment/experiment.h"

namespace typodont {

struct TrialLog {
  ExperimentPlan plan;  // only question, models, rule
  std::string scene;    // as the user wrote it
  std::string subject;  // name or code; may be empty
  std::vector<AnsweredTrial> answered;
};

/// First the lines with '#', which hold the plan.
std::string table_of(const TrialLog& log);
/// Killed while writing, the file keeps the previous trial's table.
void write_trial_log(const std::filesystem::path& file, const TrialLog& log);
/// Throws Error with file, line and column.
TrialLog read_trial_log(const std::filesystem::path& file);

}  // namespace typodont
