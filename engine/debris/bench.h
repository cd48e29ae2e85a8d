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

/// Time of a step: chips a second after their creation, without and with suction; flying and bouncing chips; none;
/// water on a wet ball in 1/30 s. Baseline: reading and writing the data of a step.
std::vector<BenchRow> bench_debris(const BenchOptions& options);

}  // namespace typodont::debris
