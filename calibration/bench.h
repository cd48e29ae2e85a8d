// Benchmark of the solvers: error and time for a number of touches, compared with Eigen's and OpenCV's solvers on the
// same seeded data.
#pragma once

#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::calibration {

/// Measures all solvers. Takes a few seconds; with `quick`, less than one second, with fewer trials. Each row of the
/// table has the name "task, method", and as its size the number of touches (pairs, samples, captures or corners).
std::vector<BenchRow> bench_rows(bool quick = false);

}  // namespace typodont::calibration
