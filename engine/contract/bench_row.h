// One row of a work–precision table: an error, a running time, and a baseline for comparison. Every module's bench()
// returns such rows. The bench command prints them, writes them as CSV and plots them.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace typodont {

struct BenchRow {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::string name{};        // "slide on a sphere, median", "filter block float" …
  std::string knob{};        // the setting that trades error for time: "voxel 0.1 mm", "order 300"
  double error = kNone;      // error in `error_unit`; kNone: no reference value exists
  std::string error_unit{};  // unit and kind of the error, for example "degree, greatest"
  double time_ns = kNone;    // ns, thread CPU time for one unit of `per`
  std::string per{};         // "tick", "query", "brick", "sample" …
  std::string baseline{};    // the method or the measured floor that `ratio` compares with; empty: no baseline
  double ratio = kNone;      // time divided by the baseline's time
  // problem size that determines the cost: voxels, triangles, touches; kNone if the row does not study the size
  double size = kNone;
  std::string size_unit{};
};

}  // namespace typodont
