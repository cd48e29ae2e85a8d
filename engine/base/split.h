// Splits a text at a separator.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

namespace typodont {

/// The parts of `text` between the separators, as views. An empty text gives one empty part.
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
