#include "engine/app/bench/page_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/json.h"
#include "engine/base/partial_file.h"
#include "engine/base/utf8.h"

namespace typodont {
namespace {

constexpr std::size_t kWidth = 120;  // characters, longest line of a page

std::string wrapped_line(std::string_view line) {
  const std::string_view indent = line.starts_with("- ") ? "  " : "";
  std::string out;
  std::size_t width = 0;
  while (!line.empty()) {
    const std::size_t end = std::min(line.find(' '), line.size());
    const std::string_view word = line.substr(0, end);
    const std::size_t length = count_characters(word);
    if (width > 0 && width + 1 + length > kWidth) {
      out += '\n', out += indent;
      width = indent.size();
    } else if (width > 0) {
      out += ' ', ++width;
    }
    out += word, width += length;
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return out;
}

/// Returns the anchor that Markdown viewers give to a heading: lower case, hyphens for spaces, no punctuation.
std::string anchor_of(std::string_view heading) {
  std::string anchor;
  for (const char c : heading) {
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_') {
      anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else if (c == ' ') {
      anchor += '-';
    }
  }
  return anchor;
}

}  // namespace

std::string with_contents(std::string_view page) {
  constexpr std::size_t kFew = 3;  // a page with fewer sections has no list of them
  constexpr std::string_view kHeading = "\n## ";
  const std::size_t first = page.find(kHeading);
  std::string contents;
  std::size_t count = 0;
  for (std::size_t at = first; at < page.size(); at = page.find(kHeading, at + 1), ++count) {
    const std::size_t from = at + kHeading.size();
    const std::string_view heading = page.substr(from, page.find('\n', from) - from);
    contents += fmt::format("{}[{}](#{})", count == 0 ? "Contents: " : ", ", heading, anchor_of(heading));
  }
  if (count < kFew) return std::string(page);
  return fmt::format("{}\n{}.\n{}", page.substr(0, first), contents, page.substr(first));
}

std::string wrapped(std::string_view page) {
  std::string out;
  bool code = false;
  while (!page.empty()) {
    const std::size_t end = std::min(page.find('\n'), page.size());
    const std::string_view line = page.substr(0, end);
    const bool fence = line.starts_with("```");
    code ^= fence;
    const bool text = !code && !fence && !line.starts_with("|") && !line.starts_with("#") && !line.starts_with("![");
    out += text && count_characters(line) > kWidth ? wrapped_line(line) : std::string(line);
    if (end < page.size()) out += '\n';
    page.remove_prefix(std::min(end + 1, page.size()));
  }
  return out;
}

void write_page(const std::filesystem::path& file, std::string_view page) {
  write_file_atomically(file, wrapped(with_contents(page)), FileKind::kText, Over::kItsInput);
}

void require_page(const std::filesystem::path& file) {
  if (file.extension() != ".md") throw Error("--page", "", file.string(), "the name of a page (.md)");
  require_output(file, FileKind::kText);
  std::error_code missing;
  if (!std::filesystem::is_regular_file(file, missing)) return;
  std::string line;
  if (LineReader(file, InputKind::kAny).next(line) && !line.starts_with("# "))
    throw Error(file.string(), "", "a file of another kind", "a page of the benchmark, or no file");
}

}  // namespace typodont
