// Generates docs/models.md: the rows of `typodont bench models` as answers to questions, each with one plot or table.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont {

/// One value from the comparison of the contact models: a row whose name is "tissue, motion, model: measure".
struct ModelFigure {
  std::string tissue, motion, model, measure;
  const BenchRow* row = nullptr;
};
/// Selects the rows whose names have the form "tissue, motion, model: measure", and keeps their order. Other rows are
/// omitted.
std::vector<ModelFigure> model_figures(const std::vector<BenchRow>& rows);

/// Returns for each contact model the number of tasks for which the table of recommendations names it as the best.
/// Models that are the best in no task are omitted.
std::map<std::string, int> tasks_won(const std::vector<ModelFigure>& figures);

/// Writes FILE.md and one SVG per question, in a folder of the same name beside it. `machine`: processor, compiler,
/// flags and date in one line. Throws Error if a file cannot be written.
void write_models_page(const std::filesystem::path& file, const std::vector<BenchRow>& rows,
                       const std::string& machine);

}  // namespace typodont
