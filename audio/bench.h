// Rows of `typodont bench`: error and time per sample.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::audio {

struct BenchOptions {
  std::filesystem::path recording;  // recording to which the models are fitted
  std::vector<int> orders = {4, 16, 50, 100, 200, 300, 400, 600};
  int repeats = 9;
  int samples = 16384;  // number of samples per repetition
};

/// Runs the benchmark. Throws Error like fit_recording().
std::vector<BenchRow> audio_bench(const BenchOptions& options);

}  // namespace typodont::audio
