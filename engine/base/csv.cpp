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

std::string_view trim(std::string_view s) {
  while (!s.empty() && std::strchr(" \t\r", s.front())) s.remove_prefix(1);
  while (!s.empty() && std::strchr(" \t\r", s.back())) s.remove_suffix(1);
  return s;
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const auto comma = line.find(',');
    cells.push_back(trim(line.substr(0, comma)));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

int CsvTable::column(std::string_view name) const {
  const auto it = std::find(columns.begin(), columns.end(), name);
  return it == columns.end() ? -1 : static_cast<int>(it - columns.begin());
}

void CsvTable::fail(std::size_t row, std::string_view name, std::string_view found, std::string_view expected) const {
  throw Error(file.string(), fmt::format("line {}, column {}", lines.at(row), name), found, expected);
}

CsvTable read_csv(const std::filesystem::path& file, const std::vector<std::string>& required,
                  const std::vector<std::string>& optional, const std::map<std::string, CellReader>& readers) {
  LineReader in(file, InputKind::kTable);
  CsvTable table;
  table.file = file;
  std::string line;
  while (in.next(line)) {
    const std::size_t number = in.number();
    // removes the byte order mark that spreadsheets write
    if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    const std::string_view text = trim(line);
    if (text.empty() || text.front() == '#') continue;
    const auto cells = split(text);
    const std::string place = fmt::format("line {}", number);

    if (table.columns.empty()) {  // the first line that is not empty is the header
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
      const char* end = cells[i].data() + cells[i].size();
      const auto result = std::from_chars(cells[i].data(), end, value);
      const bool empty_optional = cells[i].empty() && contains(optional, table.columns[i]);
      if (!empty_optional && (result.ec != std::errc() || result.ptr != end || !std::isfinite(value))) {
        throw Error(file.string(), fmt::format("{}, column {}", place, table.columns[i]),
                    cells[i].empty() ? "nothing" : fmt::format("\"{}\"", cells[i].substr(0, 40)), "a finite number");
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
