// A score in the numbers that pages, window and terminal print: tenths of a point, rounded down so that they add up.
#pragma once

#include <vector>

#include "engine/session/score.h"

namespace typodont::session {

/// Points rounded down to tenths, because rounding up could show a missed pass mark as reached.
double printed_points(double points);

/// The numbers of a score. The items add up to `sum`; `sum` × `percent` is `total`, to the nearest or rounded down.
struct PrintedScore {
  struct Item {
    double points = 0, full = 0;
  };
  std::vector<Item> items;  // as Score::items
  double sum = 0;           // of the items' points
  double percent = 100;     // completed percentage of the task
  int percent_decimals = 0;
  double total = 0;
};
PrintedScore printed_score(const Score& score);

}  // namespace typodont::session
