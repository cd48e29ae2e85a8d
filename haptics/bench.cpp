#include "haptics/bench.h"

#include "haptics/bench/rows.h"

namespace typodont::haptics {

std::vector<BenchRow> bench_contact(const BenchOptions& options) {
  std::vector<BenchRow> rows;
  bench::slide_rows(options, rows);
  bench::drilling_rows(options, rows);
  bench::process_rows(options, rows);
  bench::removal_rows(options, rows);
  bench::free_air_row(options, rows);
  if (bench::by_default(options)) bench::soft_rows(options, rows);
  bench::deadline_rows(options, rows);
  return rows;
}

}  // namespace typodont::haptics
