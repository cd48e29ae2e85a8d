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
  std::string knob{};        // the setting that determines error and time: "voxel 0.1 mm", "order 300"
  double error = kNone;      // error in `error_unit`; kNone if no reference value exists
  std::string error_unit{};  // unit and kind of the error, for example "degree, greatest"
  double time_ns = kNone;    // thread CPU time in ns for one unit of `per`
  std::string per{};         // the unit of work that takes the time of this row: "tick", "query", "brick", "sample" …
  // the method, or the measured lower limit, with whose time `time_ns` is compared; empty: no comparison
  std::string baseline{};
  double ratio = kNone;  // time divided by the baseline's time
  // size of the problem (number of voxels, triangles or touches); kNone if the row does not study how the time depends
  // on the size
  double size = kNone;
  std::string size_unit{};
};

}  // namespace typodont
