// What the sound costs and how true it is: work-precision rows for `typodont bench`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::audio {

struct BenchOptions {
  std::filesystem::path recording;  // that the models are fitted to
  std::vector<int> orders = {4, 16, 50, 100, 200, 300, 400, 600};
  int repeats = 9;
  int samples = 16384;  // a repeat
};

/// Throws Error as fit_recording does.
std::vector<BenchRow> audio_bench(const BenchOptions& options);

}  // namespace typodont::audio
