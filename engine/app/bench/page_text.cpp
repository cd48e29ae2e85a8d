#include "engine/app/bench/page_text.h"

#include <algorithm>
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

}  // namespace

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
  write_file_atomically(file, wrapped(page), FileKind::kText, Over::kItsInput);
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
