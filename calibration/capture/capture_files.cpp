#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "calibration/calibration_files.h"
#include "calibration/routine.h"
#include "engine/base/csv.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/json.h"
#include "engine/base/units.h"

namespace typodont::calibration {

namespace {

const std::vector<std::string> kJoints = {"a_rad", "b_rad", "c_rad", "d_rad", "e_rad", "f_rad"};
const std::vector<std::string> kDots = {"left_u", "left_v", "right_u", "right_v"};

std::vector<std::string> joined(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// Access to one row of a table by column name.
struct Row {
  const CsvTable& table;
  std::size_t index;

  double operator[](std::string_view column) const { return table.value(index, column); }
  dvec3 point(const char* x, const char* y, const char* z) const {
    return dvec3((*this)[x], (*this)[y], (*this)[z]) * kMillimetre;
  }
  /// Returns true if all `columns` have values, false if none has. Throws Error if only some have.
  bool has(const std::vector<std::string>& columns) const {
    std::size_t present = 0;
    for (const auto& column : columns) present += std::isfinite((*this)[column]);
    if (present != 0 && present != columns.size()) {
      table.fail(index, columns[0], fmt::format("{} of {} values", present, columns.size()),
                 fmt::format("all or none of {}", fmt::join(columns, ",")));
    }
    return present != 0;
  }
  bool flag(const char* column) const {
    const double value = (*this)[column];
    if (value != 0 && value != 1) table.fail(index, column, fmt::format("{}", value), "0 or 1");
    return value == 1;
  }
  std::optional<ArmReading> reading() const {
    if (!has(kJoints)) return std::nullopt;
    ArmReading reading;
    for (std::size_t i = 0; i < 6; ++i) reading.angle[i] = (*this)[kJoints[i]];
    return reading;
  }
};

template <class F>
void each_row(const CsvTable& table, F visit) {
  for (std::size_t i = 0; i < table.rows.size(); ++i) visit(Row{table, i});
}

std::string joints(const std::optional<ArmReading>& reading) {
  if (!reading) return ",,,,,";
  return fmt::format("{}", fmt::join(reading->angle, ","));
}
std::string mm(const dvec3& p) {
  return fmt::format("{},{},{}", p.x * 1e3, p.y * 1e3, p.z * 1e3);
}

}  // namespace

std::vector<ArmCapture> read_arm_captures(const std::filesystem::path& file) {
  const std::vector<std::string> known = {"kx_mm", "ky_mm", "kz_mm"};
  const CsvTable table = read_csv(file, joined({"group"}, kJoints), known);
  std::vector<ArmCapture> captures;
  each_row(table, [&](const Row& row) {
    const double group = row["group"];
    if (group != std::floor(group) || std::abs(group) > 1e6) {
      table.fail(row.index, "group", fmt::format("{}", group), "a whole number: one per socket or plate");
    }
    ArmCapture capture{static_cast<int>(group), std::nullopt, *row.reading()};
    if (row.has(known)) capture.known = row.point("kx_mm", "ky_mm", "kz_mm");
    captures.push_back(capture);
  });
  return captures;
}

std::vector<MarkCapture> read_mark_captures(const std::filesystem::path& file) {
  const CsvTable table = read_csv(file, {"u", "v", "x_mm", "y_mm", "z_mm"}, kJoints);
  std::vector<MarkCapture> captures;
  each_row(table, [&](const Row& row) {
    captures.push_back({{row["u"], row["v"]}, {row.point("x_mm", "y_mm", "z_mm"), row.reading()}});
  });
  return captures;
}

std::vector<Touch> read_touches(const std::filesystem::path& file) {
  const CsvTable table = read_csv(file, {"x_mm", "y_mm", "z_mm"}, kJoints);
  std::vector<Touch> touches;
  each_row(table, [&](const Row& row) { touches.push_back({row.point("x_mm", "y_mm", "z_mm"), row.reading()}); });
  return touches;
}

std::vector<EyeCapture> read_eye_captures(const std::filesystem::path& file) {
  const CsvTable table = read_csv(file, {"right", "u", "v", "x_mm", "y_mm", "z_mm"}, kJoints);
  std::vector<EyeCapture> captures;
  each_row(table, [&](const Row& row) {
    captures.push_back({row.flag("right"), {row["u"], row["v"]}, {row.point("x_mm", "y_mm", "z_mm"), row.reading()}});
  });
  return captures;
}

std::vector<PairCapture> read_pair_captures(const std::filesystem::path& file) {
  const CsvTable table = read_csv(file, {"hx_mm", "hy_mm", "hz_mm", "dx_mm", "dy_mm", "dz_mm"}, joined(kDots, kJoints));
  if (table.rows.empty()) throw Error(file.string(), "", "no rows", "at least one pair of points");
  std::vector<PairCapture> captures;
  each_row(table, [&](const Row& row) {
    PairCapture capture{
        row.point("dx_mm", "dy_mm", "dz_mm"), {row.point("hx_mm", "hy_mm", "hz_mm"), row.reading()}, {}};
    if (row.has(kDots)) {
      capture.dots = Dots{{row["left_u"], row["left_v"]}, {row["right_u"], row["right_v"]}};
    }
    captures.push_back(capture);
  });
  return captures;
}

void write_captures(const std::filesystem::path& folder, const Captures& captures, std::string_view only) {
  make_folder(folder);
  const auto write = [&](const char* name, std::string_view columns, const auto& captures_of_step, auto&& row) {
    if (captures_of_step.empty() || (!only.empty() && only != name)) return;
    std::string text = fmt::format("{}\n", columns);
    for (const auto& capture : captures_of_step) text += row(capture) + '\n';
    write_file_atomically(folder / name, text, FileKind::kTable, Over::kItsInput);
  };
  const auto touch = [](const Touch& t) { return mm(t.p_H) + ',' + joints(t.reading); };
  const std::string angles = fmt::format("{}", fmt::join(kJoints, ",")), touched = "x_mm,y_mm,z_mm," + angles;
  write("arm.csv", "group,kx_mm,ky_mm,kz_mm," + angles, captures.arm, [](const ArmCapture& c) {
    return fmt::format("{},{},{}", c.group, c.known ? mm(*c.known) : ",,", joints(c.reading));
  });
  write("marks.csv", "u,v," + touched, captures.marks,
        [&](const MarkCapture& c) { return fmt::format("{},{},{}", c.mark.u, c.mark.v, touch(c.touch)); });
  write("mirror.csv", touched, captures.mirror, touch);
  write("drift.csv", touched, captures.drift_marks, touch);
  write("eyes.csv", "right,u,v," + touched, captures.eyes, [&](const EyeCapture& c) {
    return fmt::format("{},{},{},{}", c.right ? 1 : 0, c.dot.u, c.dot.v, touch(c.touch));
  });
  const auto pair = [](const PairCapture& c) {
    const std::string dots =
        c.dots ? fmt::format("{},{},{},{}", c.dots->left.u, c.dots->left.v, c.dots->right.u, c.dots->right.v) : ",,,";
    return fmt::format("{},{},{},{}", mm(c.touch.p_H), mm(c.shown_D), dots, joints(c.touch.reading));
  };
  const std::string paired = "hx_mm,hy_mm,hz_mm,dx_mm,dy_mm,dz_mm,left_u,left_v,right_u,right_v," + angles;
  write("register.csv", paired, captures.registration, pair);
  write("verify.csv", paired, captures.verification, pair);
  const auto stream = [&](const char* name, const Stream& s) {
    std::vector<std::size_t> samples(s.t.size());
    std::iota(samples.begin(), samples.end(), std::size_t{0});
    write(name, "t_s,x_mm,y_mm,z_mm", samples, [&](std::size_t i) { return fmt::format("{},{}", s.t[i], mm(s.p[i])); });
  };
  stream("delay_a.csv", captures.delay_a);
  stream("delay_b.csv", captures.delay_b);
}

Captures read_captures(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder))
    throw Error(folder.string(), "", "no such folder", "a folder of captures");
  Captures captures;
  const auto there = [&](const char* name) { return std::filesystem::exists(folder / name); };
  if (there("arm.csv")) captures.arm = read_arm_captures(folder / "arm.csv");
  if (there("marks.csv")) captures.marks = read_mark_captures(folder / "marks.csv");
  if (there("mirror.csv")) captures.mirror = read_touches(folder / "mirror.csv");
  if (there("drift.csv")) captures.drift_marks = read_touches(folder / "drift.csv");
  if (there("eyes.csv")) captures.eyes = read_eye_captures(folder / "eyes.csv");
  if (there("register.csv")) captures.registration = read_pair_captures(folder / "register.csv");
  if (there("verify.csv")) captures.verification = read_pair_captures(folder / "verify.csv");
  if (there("delay_a.csv") && there("delay_b.csv")) {
    captures.delay_a = read_stream(folder / "delay_a.csv"), captures.delay_b = read_stream(folder / "delay_b.csv");
  }
  return captures;
}

}  // namespace typodont::calibration
