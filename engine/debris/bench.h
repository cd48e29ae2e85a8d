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

/// Measures three cases: chips one second after the last one was created; chips that still fly and bounce; and droplets
/// and film on a wet ball, in a step of 1/30 s. In the first two cases, a ball of tissue is drilled. The baseline only
/// reads and writes the data of each step: positions, velocities and drag factors.
std::vector<BenchRow> bench_debris(const BenchOptions& options);

}  // namespace typodont::debris
