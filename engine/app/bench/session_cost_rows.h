// CPU time of live sessions, in core-seconds per minute.
#pragma once

#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont {

/// Adds rows for live sessions without a picture: with the hand at rest, and while the hand drills. `quick`: true for
/// shorter sessions.
void session_cost_rows(bool quick, std::vector<BenchRow>& rows);

}  // namespace typodont
