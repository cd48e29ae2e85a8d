// Tables of numbers: column names, then rows of finite numbers.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace typodont {

/// An empty cell of an optional column is NaN.
struct CsvTable {
  std::filesystem::path file;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
  std::vector<std::size_t> lines;  // line in the file, per row

  /// -1: none.
  int column(std::string_view name) const;
  /// Error with file, line and column.
  [[noreturn]] void fail(std::size_t row, std::string_view column, std::string_view found,
                         std::string_view expected) const;
};

/// For cells that are no plain numbers. NaN: invalid.
struct CellReader {
  std::function<double(std::string_view cell)> read;
  std::string expected;  // after "expected" in the message, for example "a tissue's name"
};

/// Separated by commas, semicolons or tabs; cells may be quoted. With semicolons or tabs the decimal mark may be a
/// comma, the same everywhere. Columns in any order: all `required`, any `optional`, no others. Required cells are
/// finite numbers, except where `readers` has a reader. Lines with '#' are comments. Throws Error with file, line and
/// column.
CsvTable read_csv(const std::filesystem::path& file, const std::vector<std::string>& required,
                  const std::vector<std::string>& optional = {}, const std::map<std::string, CellReader>& readers = {});

}  // namespace typodont
