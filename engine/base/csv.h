// Reads tables of numbers (CSV): a header with column names, then rows of finite numbers.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace typodont {

/// A table. An empty cell of an optional column is NaN.
struct CsvTable {
  std::filesystem::path file;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
  std::vector<std::size_t> lines;  // line number in the file, for each row

  /// Index of the column with this name; -1: none.
  int column(std::string_view name) const;
  /// Value of a cell; NaN if the table has no such column.
  double value(std::size_t row, std::string_view name) const;
  /// Throws an Error that names file, line and column.
  [[noreturn]] void fail(std::size_t row, std::string_view column, std::string_view found,
                         std::string_view expected) const;
};

/// Converts cells that are not plain numbers. NaN means that the cell is invalid.
struct CellReader {
  std::function<double(std::string_view cell)> read;
  std::string expected;  // text after "expected" in an error message, for example "a tissue's name"
};

/// Names of the columns in the header; empty: the file has no header. Throws Error if the file cannot be read.
std::vector<std::string> csv_columns(const std::filesystem::path& file);

/// Reads a table. Cells are separated by commas, semicolons or tabs, and may be quoted; lines with '#' are comments.
/// Columns: all names in `required` must exist; names in `optional` may. Throws Error with file, line and column.
CsvTable read_csv(const std::filesystem::path& file, const std::vector<std::string>& required,
                  const std::vector<std::string>& optional = {}, const std::map<std::string, CellReader>& readers = {});

}  // namespace typodont
