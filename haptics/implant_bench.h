// Benchmark of the contact model "implant" for `typodont bench`: time of a tick.
#pragma once

#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::haptics {

/// Measures ticks of the model "implant" in free motion and in a bed (a drilled hole). `quick`: fewer ticks.
std::vector<BenchRow> bench_implant(bool quick);

}  // namespace typodont::haptics
