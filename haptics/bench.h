// What touching and cutting cost and how true they are: work-precision rows for `typodont bench`.
#pragma once

#include <string>
#include <vector>

namespace typodont::haptics {

/// One row: at this setting of the knob, this error for this time.
struct BenchRow {
  std::string name;        // "slide on a sphere", "drilling tick" …
  std::string knob;        // "voxel 0.1 mm"
  double error = 0;        // in the unit that follows; of no meaning while that is empty
  std::string error_unit;  // "degree, greatest"
  double time_ns = 0;      // per unit of `per`, CPU time of the thread
  std::string per;         // "tick", "query", "cut" …
  std::string baseline;    // what the ratio is to; empty: nothing
  double ratio = 0;        // time over the baseline's
};

struct BenchOptions {
  int ticks = 2000;  // per run; the 99.9th percentile wants a thousand or more
  std::vector<double> voxels_mm = {0.2, 0.1, 0.05};
};

std::vector<BenchRow> bench_contact(const BenchOptions& options);

}  // namespace typodont::haptics
