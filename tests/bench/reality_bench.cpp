// Cutting against published experiments: every row of reality/experiments.csv that states its conditions
// (docs/reality.md). The page compares; this program only simulates.
#include <cmath>

#include "tests/bench/bench.h"
#include "tests/bench/reality/experiments.h"

namespace typodont::bench {

void add_cases() {
  for (const Experiment& e : experiments()) {
    add(e.id, [e](benchmark::State& state) {
      const Band band = simulate(e, smoke());
      state.counters["low"] = std::isfinite(band.low) ? band.low : 0;
      state.counters["high"] = std::isfinite(band.high) ? band.high : 0;
    });
  }
}

}  // namespace typodont::bench
