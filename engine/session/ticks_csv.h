// Ticks as CSV, columns as in session files (docs/session_format.md).
#pragma once

#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/partial_file.h"
#include "engine/contract/contact.h"

namespace typodont::session {

/// Writes ticks as CSV. Each number is the shortest text that gives the same double, so equal ticks give equal bytes.
/// Without finish(), no file is created. Throws Error.
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

/// Reads ticks. A missing column (orientation, tissue patch, cuts) gives default values; a missing `index` is the row
/// number. `needed`: columns that the file must have; empty: all columns of a session. Throws Error with line and
/// column.
std::vector<ServoTick> read_ticks_csv(const std::filesystem::path& file,
                                      std::initializer_list<std::string_view> needed = {});

/// The columns' names, in the order of the first line.
std::vector<std::string> ticks_csv_columns();

}  // namespace typodont::session
