// What the debris costs: rows for `typodont bench`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace typodont::debris {

/// One row: with this many particles, this time for a step.
struct BenchRow {
  std::string name;      // "step", "step while drilling", "step with suction", "memory floor" …
  std::string knob;      // "100000 particles"
  double time_ns = 0;    // per step, CPU time of the thread, median
  double slow_ns = 0;    // … and 90th percentile
  std::string baseline;  // what the ratio is to; empty: nothing
  double ratio = 0;      // median over the baseline's
};

struct BenchOptions {
  std::size_t particles = 100'000;
  int repeats = 500;
};

/// Chips of a ball of tissue under the drill: a second after the last was born, and while they still fly and bounce.
/// The floor reads and writes what every step must, and nothing else: positions, velocities and what drag leaves of
/// them.
std::vector<BenchRow> bench_debris(const BenchOptions& options);

}  // namespace typodont::debris
