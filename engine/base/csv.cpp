#include "engine/base/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "engine/base/error.h"
#include "engine/base/input_file.h"

namespace typodont {

namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // spreadsheet programs write it

std::string_view trim(std::string_view s) {
  while (!s.empty() && std::strchr(" \t\r", s.front())) s.remove_prefix(1);
  while (!s.empty() && std::strchr(" \t\r", s.back())) s.remove_suffix(1);
  return s;
}

/// The cell's text without quotation marks around it.
std::string_view unquoted(std::string_view cell) {
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') return trim(cell.substr(1, cell.size() - 2));
  return cell;
}

/// Splits a line at separators outside quotation marks.
std::vector<std::string_view> cells_of(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  bool quoted = false;
  std::size_t from = 0;
  for (std::size_t at = 0; at <= line.size(); ++at) {
    if (at < line.size() && line[at] == '"') quoted = !quoted;
    if (at < line.size() && (quoted || line[at] != separator)) continue;
    cells.push_back(unquoted(trim(line.substr(from, at - from))));
    from = at + 1;
  }
  return cells;
}

/// The header's separator: tab, semicolon or comma.
char separator_of(std::string_view header) {
  for (const char separator : {'\t', ';'})
    if (header.find(separator) != std::string_view::npos) return separator;
  return ',';
}

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

int CsvTable::column(std::string_view name) const {
  const auto it = std::find(columns.begin(), columns.end(), name);
  return it == columns.end() ? -1 : static_cast<int>(it - columns.begin());
}

double CsvTable::value(std::size_t row, std::string_view name) const {
  const int at = column(name);
  return at < 0 ? std::numeric_limits<double>::quiet_NaN() : rows[row][static_cast<std::size_t>(at)];
}

void CsvTable::fail(std::size_t row, std::string_view name, std::string_view found, std::string_view expected) const {
  throw Error(file.string(), fmt::format("line {}, column {}", lines.at(row), name), found, expected);
}

std::vector<std::string> csv_columns(const std::filesystem::path& file) {
  LineReader in(file, InputKind::kTable);
  for (std::string line; in.next(line);) {
    if (in.number() == 1 && line.starts_with(kByteOrderMark)) line.erase(0, kByteOrderMark.size());
    if (trim(line).empty() || trim(line).front() == '#') continue;
    const auto cells = cells_of(line, separator_of(line));
    return {cells.begin(), cells.end()};
  }
  return {};
}

CsvTable read_csv(const std::filesystem::path& file, const std::vector<std::string>& required,
                  const std::vector<std::string>& optional, const std::map<std::string, CellReader>& readers) {
  LineReader in(file, InputKind::kTable);
  CsvTable table;
  table.file = file;
  std::string line;
  char separator = ',', decimal_mark = 0;  // 0: not seen yet
  while (in.next(line)) {
    const std::size_t number = in.number();
    const std::string place = fmt::format("line {}", number);
    if (number == 1 && line.starts_with(kByteOrderMark)) line.erase(0, kByteOrderMark.size());
    if (number == 1 && (line.starts_with("\xFF\xFE") || line.starts_with("\xFE\xFF")))
      throw Error(file.string(), place, "text in UTF-16", "text in UTF-8");
    if (const auto end = line.find('\r'); end < line.find_last_not_of('\r') && end != std::string::npos)
      throw Error(file.string(), place, "lines that end with CR alone", "lines that end with LF or CR LF");
    const bool is_header = table.columns.empty();  // true for the first line that is not empty
    if (trim(line).empty() || trim(line).front() == '#') continue;
    if (is_header) separator = separator_of(line);
    // Skips empty rows, which spreadsheet programs also write.
    if (!is_header && line.find_first_not_of(std::string(" \t\r") + separator) == std::string::npos) continue;
    const auto cells = cells_of(line, separator);

    if (is_header) {
      for (const auto cell : cells) {
        if (!contains(required, cell) && !contains(optional, cell)) {
          throw Error(file.string(), place, fmt::format("column \"{}\"", cell.substr(0, 40)),
                      fmt::format("the columns {}", fmt::join(required, ",")));
        }
        if (contains(table.columns, cell)) {
          throw Error(file.string(), place, fmt::format("column \"{}\" twice", cell.substr(0, 40)), "each column once");
        }
        table.columns.emplace_back(cell);
      }
      for (const auto& name : required) {
        if (!contains(table.columns, name)) {
          throw Error(file.string(), place, fmt::format("no column \"{}\"", name),
                      fmt::format("the columns {}", fmt::join(required, ",")));
        }
      }
      continue;
    }

    if (cells.size() != table.columns.size()) {
      throw Error(file.string(), place, fmt::format("{} cells", cells.size()), fmt::format("{}", table.columns.size()));
    }
    std::vector<double> row;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (const auto reader = readers.find(table.columns[i]); reader != readers.end()) {
        row.push_back(reader->second.read(cells[i]));
        if (std::isfinite(row.back())) continue;
        throw Error(file.string(), fmt::format("{}, column {}", place, table.columns[i]),
                    fmt::format("\"{}\"", cells[i].substr(0, 40)), reader->second.expected);
      }
      double value = std::numeric_limits<double>::quiet_NaN();
      std::string digits(cells[i]);
      if (const auto mark = digits.find_first_of(separator == ',' ? "." : ".,"); mark != std::string::npos) {
        // "1,234" is 1234 in English and 1.234 in German, so a table may use only one decimal mark.
        if (decimal_mark == 0) decimal_mark = digits[mark];
        if (digits[mark] == decimal_mark)
          digits[mark] = '.';
        else
          digits.clear();  // not a number
      }
      const char* end = digits.data() + digits.size();
      const auto result = std::from_chars(digits.data(), end, value);
      const bool empty_optional = cells[i].empty() && contains(optional, table.columns[i]);
      if (!empty_optional && (result.ec != std::errc() || result.ptr != end || !std::isfinite(value))) {
        throw Error(file.string(), fmt::format("{}, column {}", place, table.columns[i]),
                    cells[i].empty() ? "nothing" : fmt::format("\"{}\"", cells[i].substr(0, 40)),
                    decimal_mark == ',' ? "a finite number with a decimal comma" : "a finite number");
      }
      row.push_back(value);
    }
    table.rows.push_back(std::move(row));
    table.lines.push_back(number);
  }
  if (table.columns.empty()) {
    throw Error(file.string(), "", "an empty file", fmt::format("the columns {}", fmt::join(required, ",")));
  }
  return table;
}

}  // namespace typodont
