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

/// Measures three cases. In two of them, a ball of tissue is drilled: one second after the last chip was created, and
/// while chips still fly and bounce. In the third, the ball is wet: droplets and film in a step of 1/30 s. The baseline
/// only reads and writes the data of each step: positions, velocities and drag factors.
std::vector<BenchRow> bench_debris(const BenchOptions& options);

}  // namespace typodont::debris
