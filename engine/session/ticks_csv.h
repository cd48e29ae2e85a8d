// Ticks as CSV, columns as in a session file (docs/session_format.md).
#pragma once

#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/base/partial_file.h"
#include "engine/contract/contact.h"

namespace typodont::session {

/// No file without finish(). Shortest text that gives the same double, so equal ticks give equal bytes. Throws Error.
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

/// Without a column (orientation, patch, cuts): defaults; `index` is the row. Throws Error with line and column.
std::vector<ServoTick> read_ticks_csv(const std::filesystem::path& file);

/// In the first line's order.
std::vector<std::string> ticks_csv_columns();

}  // namespace typodont::session
