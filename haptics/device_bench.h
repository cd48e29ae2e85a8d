// Latency of a hand's device, and accuracy of its velocity: rows for `typodont bench`.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::haptics {

struct DeviceBenchOptions {
  int ticks = 100'000;           // ticks per run; the 99.9th percentile needs many ticks
  std::filesystem::path assets;  // folder that contains devices/*.json
};

/// Measures the time from a device's sample to the written force (median and 99.9 %), with the safety layer, over a
/// link in memory: this program's part of the latency, without USB. A loop without work is measured for comparison.
/// Then measures the loop with the servo's contact, and compares the velocity estimator with plain differences, at the
/// quantisation of a common arm and at several rates.
std::vector<BenchRow> bench_devices(const DeviceBenchOptions& options);

}  // namespace typodont::haptics
