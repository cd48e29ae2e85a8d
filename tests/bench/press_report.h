// Presses of a ball where the exact contact is known, as results of a benchmark.
#pragma once

#include "tests/bench/bench.h"
#include "tests/support/presses.h"

namespace typodont::bench {

inline void report(benchmark::State& state, const test::PressErrors& errors) {
  const auto max = [](const std::vector<double>& v) { return test::PressErrors::quantile(v, 1); };
  state.counters["direction_median_deg"] = errors.median_direction();
  state.counters["direction_max_deg"] = max(errors.direction);
  state.counters["force_max_percent"] = 100 * max(errors.force);
  state.counters["position_max_voxel"] = max(errors.position);
}

}  // namespace typodont::bench
