// Reads tables of numbers: a header line of column names, then rows of finite numbers.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace typodont {

/// A table of doubles with named columns. Empty optional cells are NaN.
struct CsvTable {
  std::filesystem::path file;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
  std::vector<std::size_t> lines;  // for each row its line number in the file, for messages

  /// Index of a column, or -1.
  int column(std::string_view name) const;
  /// Throws Error naming file, line and column.
  [[noreturn]] void fail(std::size_t row, std::string_view column, std::string_view found,
                         std::string_view expected) const;
};

/// Reads cells that are not plain numbers. NaN means that the cell is invalid.
struct CellReader {
  std::function<double(std::string_view cell)> read;
  std::string expected;  // text for the message, e.g. "a tissue's name"
};

/// Reads a file whose columns are exactly `required`, in any order, plus any of `optional`. Every cell of a required
/// column is a finite number. The columns named in `readers` are read by those readers instead. A line that starts with
/// '#' is a comment. Throws Error naming file, line, column, found, expected.
CsvTable read_csv(const std::filesystem::path& file, const std::vector<std::string>& required,
                  const std::vector<std::string>& optional = {}, const std::map<std::string, CellReader>& readers = {});

}  // namespace typodont
