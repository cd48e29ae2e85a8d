// Benchmarks of devices for `typodont bench`: latency, and accuracy of the velocity estimate.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::haptics {

struct DeviceBenchOptions {
  int ticks = 100'000;           // ticks per run; the 99.9th percentile requires many ticks
  std::filesystem::path assets;  // folder that contains devices/*.json
};

/// Measures the time from a device's sample to the written force (median and 99.9th percentile), with the safety layer.
/// The simulated link has no delay, so the result is the latency of the program without USB. For comparison, also
/// measures a loop without work and a loop with a servo in contact. Compares the velocity estimator with simple
/// differences, at the position resolution of a typical arm and at several rates.
std::vector<BenchRow> bench_devices(const DeviceBenchOptions& options);

}  // namespace typodont::haptics
