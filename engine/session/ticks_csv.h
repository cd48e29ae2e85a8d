// Reads and writes ticks as a CSV table. The columns have the same names as in a session file (docs/session_format.md).
#pragma once

#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/base/partial_file.h"
#include "engine/contract/contact.h"

namespace typodont::session {

/// Writes a table of ticks row by row. finish() completes the file; if it is not called, no file is created. A number
/// is written as the shortest text that gives the same double when it is read. So equal ticks give equal bytes. Throws
/// Error if writing fails.
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

/// Reads a table that TicksCsvWriter wrote. Members without a column (orientation, patch, cuts) keep their defaults,
/// and `index` is the number of the row. Throws an Error that names line and column.
std::vector<ServoTick> read_ticks_csv(const std::filesystem::path& file);

/// Returns the column names in the order of the first line.
std::vector<std::string> ticks_csv_columns();

}  // namespace typodont::session
