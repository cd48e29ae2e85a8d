// Solvers against Eigen's and OpenCV's on the same seeded data.
#pragma once

#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::calibration {

/// A few seconds; `quick`: under one. Rows "task, method"; size: number of touches.
std::vector<BenchRow> bench_rows(bool quick = false);

}  // namespace typodont::calibration
