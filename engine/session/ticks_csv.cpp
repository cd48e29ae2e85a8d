#include "engine/session/ticks_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/session/format/columns.h"

namespace typodont::session {

namespace {

void append_cell(std::string& out, const Column<ServoTick>& column, const ServoTick& tick) {
  if (column.name == "tissue") {
    out += name_of(tick.tissue);
    return;
  }
  std::byte cell[8];
  column.get(tick, cell);
  if (column.type == Type::kU32) {
    std::uint32_t value;
    std::memcpy(&value, cell, sizeof value);
    fmt::format_to(std::back_inserter(out), "{}", value);
  } else {
    double value;
    std::memcpy(&value, cell, sizeof value);
    // Writes 0 instead of "-0", which looks like an error.
    fmt::format_to(std::back_inserter(out), "{}", value == 0 ? 0.0 : value);
  }
}

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t' || s.front() == '\r')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t' || s.back() == '\r')) s.remove_suffix(1);
  return s;
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const auto comma = line.find(',');
    cells.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

/// Reads a cell into the tick. False: the text is invalid for this column.
bool parse_cell(std::string_view text, const Column<ServoTick>& column, ServoTick& tick) {
  std::byte cell[8]{};
  if (column.name == "tissue") {
    const auto tissue = tissue_named(text);
    if (!tissue) return false;
    tick.tissue = *tissue;
    return true;
  }
  const char* end = text.data() + text.size();
  if (column.type == Type::kU32) {
    std::uint32_t value = 0;
    const auto result = std::from_chars(text.data(), end, value);
    if (result.ec != std::errc() || result.ptr != end) return false;
    std::memcpy(cell, &value, sizeof value);
  } else {
    double value = 0;
    const auto result = std::from_chars(text.data(), end, value);
    if (result.ec != std::errc() || result.ptr != end) return false;
    std::memcpy(cell, &value, sizeof value);
  }
  if (column.set) column.set(tick, cell);
  return true;
}

}  // namespace

std::vector<std::string> ticks_csv_columns() {
  std::vector<std::string> names;
  for (const auto& column : tick_columns()) {
    if (column.in_csv) names.push_back(column.name);
  }
  return names;
}

TicksCsvWriter::TicksCsvWriter(const std::filesystem::path& file) : partial_(file, FileKind::kTable) {
  out_ = std::fopen(partial_.path().c_str(), "wb");
  if (!out_) throw Error(file.string(), "", std::strerror(errno), "a writable place");
  buffer_ = fmt::format("{}\n", fmt::join(ticks_csv_columns(), ","));
}

TicksCsvWriter::~TicksCsvWriter() {
  if (out_) std::fclose(out_);
}

void TicksCsvWriter::append(std::span<const ServoTick> ticks) {
  for (const ServoTick& tick : ticks) {
    bool first = true;
    for (const auto& column : tick_columns()) {
      if (!column.in_csv) continue;
      if (!first) buffer_ += ',';
      first = false;
      append_cell(buffer_, column, tick);
    }
    buffer_ += '\n';
    if (buffer_.size() > (1u << 18)) write_out();
  }
}

void TicksCsvWriter::write_out() {
  errno = 0;
  if (std::fwrite(buffer_.data(), 1, buffer_.size(), out_) != buffer_.size()) {
    throw Error(partial_.file().string(), "", errno ? std::strerror(errno) : "a short write", "a writable place");
  }
  buffer_.clear();
}

void TicksCsvWriter::finish() {
  write_out();
  errno = 0;
  if (std::fclose(std::exchange(out_, nullptr)) != 0) {
    throw Error(partial_.file().string(), "", errno ? std::strerror(errno) : "a short write", "a writable place");
  }
  partial_.keep();
}

std::vector<ServoTick> read_ticks_csv(const std::filesystem::path& file,
                                      std::initializer_list<std::string_view> needed) {
  LineReader in(file, InputKind::kTable);
  std::vector<ServoTick> ticks;
  std::vector<const Column<ServoTick>*> columns;
  std::string line;
  while (in.next(line)) {
    const std::size_t number = in.number();
    const std::string_view content = trimmed(line);
    if (content.empty() || content.front() == '#') continue;
    const auto cells = split(content);
    if (columns.empty()) {
      for (const auto& column : tick_columns()) {
        if (!column.in_csv) continue;
        const bool there = std::find(cells.begin(), cells.end(), column.name) != cells.end();
        const bool must = needed.size() > 0 ? std::find(needed.begin(), needed.end(), column.name) != needed.end()
                                            : column.name != "pedal" && !column.added;
        if (!there && must) {
          throw Error(file.string(), fmt::format("line {}", number), fmt::format("no column \"{}\"", column.name),
                      needed.size() > 0 ? fmt::format("the columns {}", fmt::join(needed, ","))
                                        : fmt::format("the columns {}", fmt::join(ticks_csv_columns(), ",")));
        }
      }
      for (const auto cell : cells) {
        const Column<ServoTick>* known = nullptr;
        for (const auto& column : tick_columns()) {
          if (column.in_csv && column.name == cell) known = &column;
        }
        if (!known || std::find(columns.begin(), columns.end(), known) != columns.end()) {
          throw Error(file.string(), fmt::format("line {}", number),
                      fmt::format("column \"{}\"{}", cell.substr(0, 40), known ? " twice" : ""),
                      fmt::format("the columns {}", fmt::join(ticks_csv_columns(), ",")));
        }
        columns.push_back(known);
      }
      continue;
    }
    if (cells.size() != columns.size()) {
      throw Error(file.string(), fmt::format("line {}", number), fmt::format("{} cells", cells.size()),
                  std::to_string(columns.size()));
    }
    ServoTick tick;
    tick.index = ticks.size();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (parse_cell(cells[i], *columns[i], tick)) continue;
      throw Error(file.string(), fmt::format("line {}, column {}", number, columns[i]->name),
                  cells[i].empty() ? "nothing" : fmt::format("\"{}\"", cells[i].substr(0, 40)),
                  columns[i]->name == "tissue" ? "the name of a tissue" : "a number");
    }
    ticks.push_back(tick);
  }
  if (columns.empty()) {
    throw Error(file.string(), "", "an empty file", fmt::format("the columns {}", fmt::join(ticks_csv_columns(), ",")));
  }
  return ticks;
}

}  // namespace typodont::session
