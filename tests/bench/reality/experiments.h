// The published experiments of experiments.csv that state their conditions.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "tests/bench/reality/rig.h"

namespace typodont::bench {

struct Experiment {
  std::string id, quantity, rig, role;
  Conditions conditions;  // values as in the file: "a|b" if unknown, "a>b" to compare two
  double low = 0, high = std::numeric_limits<double>::infinity();  // accepted, in the file's unit
};
/// Throws Error.
std::vector<Experiment> experiments();

/// Simulated values over the unknown conditions, in the file's unit.
struct Band {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void add(double value);
};
/// `brief`: a tiny run of one combination, for tests of the program. Throws Error.
Band simulate(const Experiment& experiment, bool brief = false);
/// True if the band overlaps the accepted range. Simulates no more conditions than this needs. Throws Error.
bool agrees(const Experiment& experiment);

}  // namespace typodont::bench
