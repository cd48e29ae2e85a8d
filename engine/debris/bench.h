// Measures the cost of debris and returns rows for `typodont bench`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::debris {

struct BenchOptions {
  std::size_t particles = 100'000;
  int repeats = 500;
};

/// Measures the time of one step in several cases: chips one second after the last one was created, without and with
/// suction; chips that still fly and bounce; no chips; and water, as droplets and film on a wet ball, in a step of 1/30
/// s. The chips come from drilling a ball of tissue. The baseline only reads and writes the data of each step:
/// positions, velocities and drag factors.
std::vector<BenchRow> bench_debris(const BenchOptions& options);

}  // namespace typodont::debris
