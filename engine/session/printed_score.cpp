#include "engine/session/printed_score.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace typodont::session {

namespace {

constexpr double kRoundingError = 1e-7;  // tenths of a point, more than sums of points are off
constexpr int kMaxPercentDecimals = 3;

double round_down(double tenths) {
  return std::floor(tenths + kRoundingError);
}

}  // namespace

double printed_points(double points) {
  return round_down(10 * points) / 10;
}

PrintedScore printed_score(const Score& score) {
  PrintedScore printed;
  // All points below are in tenths.
  double sum = 0;
  for (const ScoreItem& item : score.items) sum += 10 * item.points;
  const double total = round_down(10 * score.points);
  // The sum is rounded up where the sum rounded down would give less than the total.
  const double up = score.completion * round_down(sum) < total - kRoundingError ? std::ceil(sum) - sum : 0;

  // Rounds running sums, so that the rounded items add up. Items with all points come first: there, both sums are
  // equal.
  std::vector<std::size_t> order(score.items.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) {
    const ScoreItem& item = score.items[i];
    const double lost = item.full - item.points;
    return std::pair(lost <= 0 ? 0 : item.points <= 0 ? 1 : 2, lost);
  });
  printed.items.resize(score.items.size());
  double points = 0, full = 0, points_before = 0, full_before = 0;
  for (const std::size_t i : order) {
    points += 10 * score.items[i].points;
    full += 10 * score.items[i].full;
    const double item_full = round_down(full + up) - full_before;
    const double item_points = std::min(item_full, round_down(points + up) - points_before);
    full_before += item_full;
    points_before += item_points;
    printed.items[i] = {item_points / 10, item_full / 10};
  }
  // Points that found no room in their item go to other items with losses.
  for (const std::size_t i : order) {
    PrintedScore::Item& item = printed.items[i];
    const double left = std::min(round_down(points + up) - points_before, 10 * (item.full - item.points));
    if (left < 0.5 || score.items[i].points <= 0) continue;
    item.points = std::round(10 * item.points + left) / 10;
    points_before += std::round(left);
  }

  // Rounds the percentage down to the fewest decimals that lead to the total.
  const auto rounded_percent = [&](int decimals) {
    const double scale = std::pow(10.0, decimals);
    return std::floor(100 * score.completion * scale + kRoundingError) / scale;
  };
  const auto leads_to_total = [&](double percent) {
    const double off = points_before * percent / 100 - total;
    return off > -0.5 && off < 1;
  };
  const double whole = rounded_percent(0);
  int decimals = std::abs(100 * score.completion - whole) < kRoundingError ? 0 : 1;
  while (decimals < kMaxPercentDecimals && !leads_to_total(rounded_percent(decimals))) ++decimals;
  printed.percent = rounded_percent(decimals);
  printed.percent_decimals = decimals;
  printed.sum = points_before / 10;
  printed.total = total / 10;
  return printed;
}

}  // namespace typodont::session
