// Counts the characters of a text in UTF-8.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace typodont {

/// Number of characters. Continuation bytes of UTF-8 are not counted.
inline std::size_t count_characters(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

}  // namespace typodont
