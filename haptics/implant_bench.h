// Time of a tick with the contact model "implant": rows for `typodont bench`.
#pragma once

#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::haptics {

/// Ticks of the model "implant", free and in a bed. `quick`: fewer ticks.
std::vector<BenchRow> bench_implant(bool quick);

}  // namespace typodont::haptics
