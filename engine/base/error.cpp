#include "engine/base/error.h"

#include <cstddef>

namespace typodont {

namespace {

// Largest length of one part of a message, bytes. Longer parts, usually quoted input, are shortened.
constexpr std::size_t kLongest = 240;

/// Shortens the part without splitting a UTF-8 character. Replaces control characters: a terminal would execute them.
std::string shown(std::string_view part) {
  std::string text(part);
  if (text.size() > kLongest) {
    std::size_t end = kLongest - 3;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
    text = text.substr(0, end) + "...";
  }
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  return text;
}

std::string compose(std::string_view file, std::string_view where, std::string_view found, std::string_view expected) {
  std::string text;
  for (const std::string_view part : {file, where}) {
    if (part.empty()) continue;
    if (!text.empty()) text.append(": ");
    text.append(part.data() == file.data() ? std::string(part) : shown(part));
  }
  if (!found.empty()) text.append(text.empty() ? "found " : ": found ").append(shown(found));
  if (!expected.empty()) text.append(", expected ").append(expected);
  return text;
}

}  // namespace

Error::Error(std::string_view file, std::string_view where, std::string_view found, std::string_view expected)
    : std::runtime_error(compose(file, where, found, expected)) {}

}  // namespace typodont
