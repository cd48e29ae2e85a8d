// What the debris costs: rows for `typodont bench`.
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

/// Chips of a ball of tissue under the drill: a second after the last was born, and while they still fly and bounce.
/// The floor reads and writes what every step must, and nothing else: positions, velocities and what drag leaves of
/// them.
std::vector<BenchRow> bench_debris(const BenchOptions& options);

}  // namespace typodont::debris
