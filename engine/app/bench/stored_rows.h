// Reads the tables of rows that `typodont bench --out` and `./run peers` write.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont {

inline constexpr std::string_view kRowColumns =
    "part,case,knob,error,error_unit,time_ns,per,baseline,ratio,size,size_unit";

/// Reads the rows of all parts from `file`. Throws Error if the file is not a table of rows.
std::map<std::string, std::vector<BenchRow>> stored_rows(const std::string& file);

}  // namespace typodont
