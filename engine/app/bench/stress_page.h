// docs/stress.md: the rows of `typodont bench stress` as a map of what each contact model survives. Made by the
// program, never typed by hand.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont {

/// How a model came through a campaign.
enum class Survival {
  kSurvived,  // all figures within what passes
  kFlawed,    // finite, bounded and held, but a step, energy or an error beyond what passes
  kFell       // not finite, beyond the force's limit, through the tissue, or without force in it
};

struct SurvivalCell {
  std::string campaign, model;
  Survival survival = Survival::kSurvived;
  std::string worst;  // the figure that is farthest beyond what passes; empty where none is
};
/// One for each campaign and model, in the rows' order. Rows whose name is not "campaign, model: measure" are left out.
std::vector<SurvivalCell> survival_of(const std::vector<BenchRow>& rows);

/// Writes FILE.md and, beside it in a folder of its name, map.svg. `machine`: processor, compiler, flags and date in
/// one line. Throws Error where the place is not writable.
void write_stress_page(const std::filesystem::path& file, const std::vector<BenchRow>& rows,
                       const std::string& machine);

}  // namespace typodont
