// What a tick of the contact model "implant" costs: rows for `typodont bench`.
#pragma once

#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::haptics {

/// Ticks of the model "implant", free and in a bed. `quick`: fewer of them.
std::vector<BenchRow> bench_implant(bool quick);

}  // namespace typodont::haptics
