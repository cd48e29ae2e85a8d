#include "engine/app/bench/stored_rows.h"

#include <fmt/format.h>

#include <cstdlib>

#include "engine/base/error.h"
#include "engine/base/input_file.h"

namespace typodont {

namespace {

/// Splits one line of a CSV file of rows into its cells.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted_now = false;
  for (const char c : line) {
    if (c == '"')
      quoted_now = !quoted_now;
    else if (c == ',' && !quoted_now)
      cells.emplace_back();
    else
      cells.back() += c;
  }
  return cells;
}

}  // namespace

std::map<std::string, std::vector<BenchRow>> stored_rows(const std::string& file) {
  LineReader in(file, InputKind::kTable);
  std::map<std::string, std::vector<BenchRow>> rows;
  for (std::string line; in.next(line);) {
    const std::size_t number = in.number();
    if (line.empty() || line[0] == '#' || line == kRowColumns) continue;
    const std::vector<std::string> c = cells_of(line);
    const auto value = [&](std::size_t i) {
      if (c[i].empty()) return BenchRow::kNone;
      char* end = nullptr;
      const double v = std::strtod(c[i].c_str(), &end);
      if (*end != 0) throw Error(file, fmt::format("line {}", number), c[i], "a number");
      return v;
    };
    if (c.size() != 11)
      throw Error(file, fmt::format("line {}", number), fmt::format("{} cells", c.size()), std::string(kRowColumns));
    rows[c[0]].push_back({.name = c[1],
                          .knob = c[2],
                          .error = value(3),
                          .error_unit = c[4],
                          .time_ns = value(5),
                          .per = c[6],
                          .baseline = c[7],
                          .ratio = value(8),
                          .size = value(9),
                          .size_unit = c[10]});
  }
  return rows;
}

}  // namespace typodont
