// Quantiles of lists of values.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace typodont {

/// The value with the index `k` after sorting. Reorders the values.
template <class T>
double nth(std::vector<T>& values, std::size_t k) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(k), values.end());
  return static_cast<double>(values[k]);
}
/// Quantile of n values, at least one: the value with the index fraction · n. `fraction`: 0 to 1.
inline double quantile(std::vector<double> values, double fraction) {
  const auto wanted = static_cast<std::size_t>(fraction * static_cast<double>(values.size()));
  return nth(values, std::min(wanted, values.size() - 1));
}
/// Like quantile(), but with the index fraction · (n − 1); 0 for no values.
template <class T>
double lower_quantile(std::vector<T> values, double fraction) {
  return values.empty() ? 0 : nth(values, static_cast<std::size_t>(fraction * static_cast<double>(values.size() - 1)));
}

}  // namespace typodont
