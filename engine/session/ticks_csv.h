// Reads and writes ticks as a CSV table. Columns: docs/session_format.md, with the same names as in a session.
#pragma once

#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/base/partial_file.h"
#include "engine/contract/contact.h"

namespace typodont::session {

/// Writes rows as they arrive into a file. finish() completes the file; if it is not called, no file is created.
/// Numbers have the shortest text that reads back as the same double, so that equal ticks give equal bytes. Throws
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

/// Reads a table that TicksCsvWriter wrote. Fields without a column (orientation, patch, cuts) keep their defaults;
/// `index` counts rows. Throws Error naming line and column.
std::vector<ServoTick> read_ticks_csv(const std::filesystem::path& file);

/// The column names of the first line, in order.
std::vector<std::string> ticks_csv_columns();

}  // namespace typodont::session
