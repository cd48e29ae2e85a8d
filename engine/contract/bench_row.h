// One row of a table of running times and errors. Every module's bench() returns such rows. The command `bench` prints
// them, writes them as CSV and plots them.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace typodont {

struct BenchRow {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::string name{};        // what was measured, for example "slide on a sphere, median" or "filter block float"
  std::string knob{};        // the setting that is varied, on which error and time depend: "voxel 0.1 mm", "order 300"
  double error = kNone;      // error of the result, in `error_unit`; kNone if there is no reference value
  std::string error_unit{};  // unit of the error, and how it was computed, for example "degree, greatest"
  double time_ns = kNone;    // ns, thread CPU time for one unit of work (see `per`)
  std::string per{};         // the unit of work to which time_ns refers: "tick", "query", "brick", "sample" …
  // name of the method, or of the measured lower limit, with which this row's time is compared; empty: no comparison
  std::string baseline{};
  double ratio = kNone;  // time_ns divided by the time of the method `baseline`
  // size of the problem (number of voxels, triangles or touches), for rows that show how the time depends on the size;
  // kNone in other rows
  double size = kNone;
  std::string size_unit{};
};

}  // namespace typodont
