#include "engine/session/ticks_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include "engine/base/csv.h"
#include "engine/base/error.h"
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
    out += fmt::format("{}", value);
  } else {
    double value;
    std::memcpy(&value, cell, sizeof value);
    // Writes 0 instead of "-0", which looks like an error.
    out += fmt::format("{}", value == 0 ? 0.0 : value);
  }
}

/// Index of the tissue with this name; NaN: unknown.
double read_tissue(std::string_view cell) {
  const auto tissue = tissue_named(cell);
  return tissue ? static_cast<double>(*tissue) : std::nan("");
}

/// Stores a value of the table in the tick.
void set_cell(double value, const Column<ServoTick>& column, ServoTick& tick) {
  if (column.name == "tissue") {
    tick.tissue = static_cast<Tissue>(value);
    return;
  }
  std::byte cell[8]{};
  if (column.type == Type::kU32) {
    const auto whole = static_cast<std::uint32_t>(value);
    std::memcpy(cell, &whole, sizeof whole);
  } else {
    std::memcpy(cell, &value, sizeof value);
  }
  if (column.set) column.set(tick, cell);
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
  std::vector<std::string> required, optional;
  for (const auto& column : tick_columns()) {
    if (!column.in_csv) continue;
    const bool must = needed.size() > 0 ? std::find(needed.begin(), needed.end(), column.name) != needed.end()
                                        : column.name != "pedal" && !column.added;
    (must ? required : optional).push_back(column.name);
  }
  const CsvTable table = read_csv(file, required, optional, {{"tissue", {read_tissue, "the name of a tissue"}}});
  std::vector<ServoTick> ticks(table.rows.size());
  for (const auto& column : tick_columns()) {
    const int at = column.in_csv ? table.column(column.name) : -1;
    for (std::size_t row = 0; at >= 0 && row < ticks.size(); ++row) {
      const double value = table.rows[row][static_cast<std::size_t>(at)];
      if (std::isnan(value)) continue;
      if (column.type == Type::kU32 && !(value >= 0 && value <= 0xffffffff && value == std::floor(value)))
        table.fail(row, column.name, fmt::format("{}", value), "a number");
      set_cell(value, column, ticks[row]);
    }
  }
  for (std::size_t row = 0; row < ticks.size(); ++row) ticks[row].index = row;
  return ticks;
}

}  // namespace typodont::session
