// Escapes text for HTML and SVG.
#pragma once

#include <string>
#include <string_view>

namespace typodont {

/// Escapes text for use between tags and in attributes. Control characters, which XML forbids, become spaces.
inline std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? ' ' : c;
    }
  }
  return out;
}

/// Beginning of an English HTML page, including the heading. `style`: CSS, not escaped.
inline std::string page_head(std::string_view title, std::string_view style) {
  const std::string text = escaped(title);
  std::string out =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\"><title>";
  out.append(text).append("</title><style>").append(style).append("</style></head><body>\n<h1>");
  return out.append(text).append("</h1>\n");
}

}  // namespace typodont
