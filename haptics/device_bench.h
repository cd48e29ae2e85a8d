// What a hand costs and how well its velocity is known: rows for `typodont bench`.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::haptics {

struct DeviceBenchOptions {
  int ticks = 100'000;           // the 99.9th percentile wants many
  std::filesystem::path assets;  // where devices/*.json lie
};

/// From a device's sample to its force written, median and 99.9 %, safety layer included, over a link that is memory:
/// our share, not USB's. Beside the same loop with no work in it. Then the same with the servo's contact in between,
/// and the velocity estimator at a common arm's quantisation beside plain differences, at several rates.
std::vector<BenchRow> bench_devices(const DeviceBenchOptions& options);

}  // namespace typodont::haptics
