// The table of `typodont bench motions` on the page of benchmark results: one line per tool, one column per motion.
#pragma once

#include <string>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont {

/// Returns the table in Markdown. `rows`: the rows of haptics::bench_motions(), whose names have the form "MOTION,
/// QUANTILE". A cell contains the quantiles of one tool and one motion in the order of the rows, µs.
std::string motions_table(const std::vector<BenchRow>& rows);

}  // namespace typodont
