// Work against precision: what each solver makes of so many touches in so much time, beside Eigen's and OpenCV's own on
// the same seeded data.
#pragma once

#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::calibration {

/// A few seconds; `quick` a fraction of one, with fewer trials. Names are "task, method"; the size is in touches:
/// pairs, samples, captures or corners.
std::vector<BenchRow> bench_rows(bool quick = false);

}  // namespace typodont::calibration
