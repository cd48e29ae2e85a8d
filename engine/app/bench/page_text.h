// Text layout of the pages that the benchmark writes.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace typodont {

/// Breaks the lines of a Markdown page after at most 120 characters, at spaces. The further lines of a list item are
/// indented by two spaces. Tables, headings, pictures and code blocks stay as they are.
std::string wrapped(std::string_view page);

/// Adds a list of links to the sections (headings of level 2) before the first section of a Markdown page. A page with
/// fewer than three sections stays as it is.
std::string with_contents(std::string_view page);

/// Writes a Markdown page with a list of its sections and with wrapped lines, completely or not at all. An existing
/// page is replaced. Throws Error if the file cannot be written.
void write_page(const std::filesystem::path& file, std::string_view page);

/// Throws Error if `file` may not be written as a Markdown page. The name must end with .md. A file that exists must be
/// empty or begin with a heading, as the pages of the benchmark do. Any other file could belong to the user, and the
/// page would destroy it.
void require_page(const std::filesystem::path& file);

}  // namespace typodont
