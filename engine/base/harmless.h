// Makes text safe for a terminal: a name from a file could contain terminal commands.
#pragma once

#include <algorithm>
#include <string>

namespace typodont {

/// Replaces control characters by '?', except line ends and tabs.
inline void make_harmless(std::string& text) noexcept {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return (c >= 0 && c < ' ' && c != '\n' && c != '\t') || c == '\x7f'; },
      '?');
}

}  // namespace typodont
