// docs/models.md: the rows of `typodont bench models` as answers to questions, one plot or table each. Made by the
// program, never typed by hand.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont {

/// One figure of the comparison: a row whose name is "tissue, motion, model: measure".
struct ModelFigure {
  std::string tissue, motion, model, measure;
  const BenchRow* row = nullptr;
};
/// The figures among rows, in their order; rows of other names are left out.
std::vector<ModelFigure> model_figures(const std::vector<BenchRow>& rows);

/// The model that comes first in most tasks of the table of choice; empty where there are no figures.
std::string model_of_most_tasks(const std::vector<ModelFigure>& figures);

/// Writes FILE.md and, beside it in a folder of its name, one SVG per question. `machine`: processor, compiler, flags
/// and date in one line. Throws Error where the place is not writable.
void write_models_page(const std::filesystem::path& file, const std::vector<BenchRow>& rows,
                       const std::string& machine);

}  // namespace typodont
