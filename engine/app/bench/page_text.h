// Text layout of the pages that the benchmark writes.
#pragma once

#include <string>
#include <string_view>

namespace typodont {

/// Breaks the lines of a Markdown page after at most 120 characters, at spaces. The further lines of a list item are
/// indented by two spaces. Tables, headings, pictures and code blocks stay as they are.
std::string wrapped(std::string_view page);

}  // namespace typodont
