// The parts of the program that `typodont bench` measures: rows of error against time, each beside its baselines
// measured in the same run. Modules bring their own rows; what needs several modules at once is measured here.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont {

struct BenchPart {
  std::string_view name;
  std::string_view title;
  std::string_view what;  // one sentence for the page
  /// `quick`: fewer repeats, a look instead of a measurement. Throws Error where something it needs is missing.
  std::vector<BenchRow> (*rows)(bool quick);
};

std::span<const BenchPart> bench_parts();

// Measured in the files beside this one.
std::vector<BenchRow> bench_render(bool quick);
std::vector<BenchRow> bench_recording(bool quick);
std::vector<BenchRow> bench_latency(bool quick);
std::vector<BenchRow> bench_length(bool quick);
std::vector<BenchRow> bench_scaling(bool quick);
std::vector<BenchRow> bench_stability(bool quick);
std::vector<BenchRow> bench_surface(bool quick);
std::vector<BenchRow> bench_undo(bool quick);

}  // namespace typodont
