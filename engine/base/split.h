// Splits a text at a separator.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

namespace typodont {

/// Returns the pieces of `text` between the separators, as views of `text`. An empty text has one empty piece.
inline std::vector<std::string_view> split(std::string_view text, std::string_view separator) {
  std::vector<std::string_view> pieces;
  for (;;) {
    const std::size_t end = std::min(text.find(separator), text.size());
    pieces.push_back(text.substr(0, end));
    if (end == text.size()) return pieces;
    text.remove_prefix(end + separator.size());
  }
}

}  // namespace typodont
