// Generates docs/stress.md: the rows of `typodont bench stress` as a map of the campaigns (series of stress tests) that
// each contact model survives.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont {

/// Result of a contact model in a campaign of stress tests.
enum class Survival {
  kSurvived,  // all figures are within their limits
  kFlawed,    // an error, an energy or a force step exceeds its limit, but none of the failures of kFell occurred
  kFell       // the force is not finite, exceeds its limit or is missing, or the tool passed through the tissue
};

struct SurvivalCell {
  std::string campaign, model;
  Survival survival = Survival::kSurvived;
  std::string worst;  // the measure that exceeds its limit most; empty if none does
};
/// Returns one cell of the map for each campaign and model, in the order of the rows. Rows whose name is not "campaign,
/// model: measure" are omitted.
std::vector<SurvivalCell> survival_of(const std::vector<BenchRow>& rows);

/// Writes FILE.md and, in a folder of the same name beside it, map.svg. `machine`: processor, compiler, flags and date
/// in one line. Throws Error if a file cannot be written.
void write_stress_page(const std::filesystem::path& file, const std::vector<BenchRow>& rows,
                       const std::string& machine);

}  // namespace typodont
