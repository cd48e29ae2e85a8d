// Reads tables of numbers: a header line of column names, then rows of finite numbers.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace typodont {

/// A table of doubles with named columns. An empty cell of an optional column is NaN.
struct CsvTable {
  std::filesystem::path file;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
  std::vector<std::size_t> lines;  // for each row: number of its line in the file, for error messages

  /// Returns the index of the column with this name, or -1 if there is none.
  int column(std::string_view name) const;
  /// Throws an Error whose message names the file, the line and the column.
  [[noreturn]] void fail(std::size_t row, std::string_view column, std::string_view found,
                         std::string_view expected) const;
};

/// A function for a column whose cells are not plain numbers, for example names. It converts a cell to a number, and
/// returns NaN if the cell is invalid.
struct CellReader {
  std::function<double(std::string_view cell)> read;
  std::string expected;  // text after "expected" in the error message, for example "a tissue's name"
};

/// Reads a table file. Cells are separated by commas, semicolons or tabs, and may stand in quotation marks. With
/// semicolons or tabs, the decimal mark may be a comma, the same in the whole table. The file must have all columns of
/// `required`, in any order, and may have columns of `optional`. Other columns are errors. Every cell of a required
/// column must be a finite number, except in columns for which `readers` contains a reader. A line that starts with '#'
/// is a comment. Throws an Error that names file, line and column.
CsvTable read_csv(const std::filesystem::path& file, const std::vector<std::string>& required,
                  const std::vector<std::string>& optional = {}, const std::map<std::string, CellReader>& readers = {});

}  // namespace typodont
