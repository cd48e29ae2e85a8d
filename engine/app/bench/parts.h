// The parts of the program that `typodont bench` measures: rows of error against time, each beside its baselines
// measured in the same run. Modules bring their own rows; what needs several modules at once is measured here.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "engine/contract/bench_row.h"
#include "haptics/contact_method.h"

namespace typodont {

/// What is asked of every part.
struct BenchRun {
  bool quick = false;                   // fewer repeats: a look instead of a measurement
  haptics::SharedContactMethod method;  // of the parts that measure a contact model; null: the default one
};

struct BenchPart {
  std::string_view name;
  std::string_view title;
  std::string_view what;  // one sentence for the page
  /// Throws Error where something that it needs is missing.
  std::vector<BenchRow> (*rows)(const BenchRun& run);
  bool takes_model = false;  // it measures BenchRun::method
};

std::span<const BenchPart> bench_parts();

// Measured in the files beside this one.
std::vector<BenchRow> bench_mesh_picture(const BenchRun& run);
std::vector<BenchRow> bench_render(const BenchRun& run);
std::vector<BenchRow> bench_import(const BenchRun& run);
std::vector<BenchRow> bench_recording(const BenchRun& run);
std::vector<BenchRow> bench_latency(const BenchRun& run);
std::vector<BenchRow> bench_length(const BenchRun& run);
std::vector<BenchRow> bench_scaling(const BenchRun& run);
std::vector<BenchRow> bench_stability(const BenchRun& run);
std::vector<BenchRow> bench_surface(const BenchRun& run);
std::vector<BenchRow> bench_undo(const BenchRun& run);

}  // namespace typodont
