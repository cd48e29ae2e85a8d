// Ticks as a table that people open in a spreadsheet. Columns: docs/session_format.md, the same names as in a session.
#pragma once

#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/base/partial_file.h"
#include "engine/contract/contact.h"

namespace typodont::session {

/// Writes rows as they come, into a file that appears whole in finish() or not at all. Numbers are the shortest text
/// that reads back as the same double: equal ticks, equal bytes. Throws Error when the disk refuses.
class TicksCsvWriter {
 public:
  explicit TicksCsvWriter(const std::filesystem::path& file);
  ~TicksCsvWriter();
  TicksCsvWriter(const TicksCsvWriter&) = delete;
  TicksCsvWriter& operator=(const TicksCsvWriter&) = delete;

  void append(std::span<const ServoTick> ticks);
  void finish();

 private:
  void write_out();
  PartialFile partial_;
  std::FILE* out_;
  std::string buffer_;
};

/// Reads such a table back. What the table has no column for (orientation, patch, cuts) keeps its default; `index`
/// counts rows. Throws Error naming line and column.
std::vector<ServoTick> read_ticks_csv(const std::filesystem::path& file);

/// The names in the first line, in order.
std::vector<std::string> ticks_csv_columns();

}  // namespace typodont::session
