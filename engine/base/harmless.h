// For text that reaches a terminal: a name from a file could contain commands for it.
#pragma once

#include <algorithm>
#include <string>

namespace typodont {

/// Replaces control characters except line ends and tabs by '?'.
inline void make_harmless(std::string& text) noexcept {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return (c >= 0 && c < ' ' && c != '\n' && c != '\t') || c == '\x7f'; },
      '?');
}

}  // namespace typodont
