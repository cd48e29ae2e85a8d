// What touching and cutting cost and how true they are: work-precision rows for `typodont bench`.
#pragma once

#include <string>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::haptics {

struct BenchOptions {
  int ticks = 2000;  // per run; the 99.9th percentile wants a thousand or more
  std::vector<double> voxels_mm = {0.2, 0.1, 0.05};
};

std::vector<BenchRow> bench_contact(const BenchOptions& options);

}  // namespace typodont::haptics
