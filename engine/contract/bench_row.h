// One row of a work–precision table: how wrong, how long, and beside what. Every part's bench() returns such rows; the
// bench command prints them, writes them as CSV and draws them.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace typodont {

struct BenchRow {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::string name{};        // "slide on a sphere, median", "filter block float" …
  std::string knob{};        // what trades one for the other: "voxel 0.1 mm", "order 300"
  double error = kNone;      // in the unit that follows; none where there is nothing to compare with
  std::string error_unit{};  // "degree, greatest"
  double time_ns = kNone;    // per unit of `per`, CPU time of the thread
  std::string per{};         // "tick", "query", "brick", "sample" …
  std::string baseline{};    // what the ratio is to: a peer's method or a measured floor; empty: nothing
  double ratio = kNone;      // time over the baseline's
  double size = kNone;  // what the cost grows with: voxels, triangles, touches; none where that is not the question
  std::string size_unit{};
};

}  // namespace typodont
