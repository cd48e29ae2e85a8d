#include <fmt/format.h>

#include <cmath>

#include "calibration/calibration_files.h"
#include "calibration/routine.h"
#include "engine/base/csv.h"
#include "engine/base/error.h"
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
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) throw Error(folder.string(), "", code.message(), "a folder to write captures into");
  const std::string columns = fmt::format("{}", fmt::join(kJoints, ","));
  const auto write = [&](const char* name, bool any, std::string header, auto&& fill) {
    if (!any || (!only.empty() && only != name)) return;
    fill(header);
    write_file_atomically(folder / name, header, FileKind::kTable, Over::kItsInput);
  };
  write("arm.csv", !captures.arm.empty(), "group,kx_mm,ky_mm,kz_mm," + columns + "\n", [&](std::string& text) {
    for (const ArmCapture& c : captures.arm) {
      text += fmt::format("{},{},{}\n", c.group, c.known ? mm(*c.known) : ",,", joints(c.reading));
    }
  });
  write("marks.csv", !captures.marks.empty(), "u,v,x_mm,y_mm,z_mm," + columns + "\n", [&](std::string& text) {
    for (const MarkCapture& c : captures.marks) {
      text += fmt::format("{},{},{},{}\n", c.mark.u, c.mark.v, mm(c.touch.p_H), joints(c.touch.reading));
    }
  });
  const auto touches = [&](const char* name, const std::vector<Touch>& list) {
    write(name, !list.empty(), "x_mm,y_mm,z_mm," + columns + "\n", [&](std::string& text) {
      for (const Touch& t : list) text += fmt::format("{},{}\n", mm(t.p_H), joints(t.reading));
    });
  };
  touches("mirror.csv", captures.mirror);
  touches("drift.csv", captures.drift_marks);
  write("eyes.csv", !captures.eyes.empty(), "right,u,v,x_mm,y_mm,z_mm," + columns + "\n", [&](std::string& text) {
    for (const EyeCapture& c : captures.eyes) {
      text +=
          fmt::format("{},{},{},{},{}\n", c.right ? 1 : 0, c.dot.u, c.dot.v, mm(c.touch.p_H), joints(c.touch.reading));
    }
  });
  const auto pairs = [&](const char* name, const std::vector<PairCapture>& list) {
    write(name, !list.empty(), "hx_mm,hy_mm,hz_mm,dx_mm,dy_mm,dz_mm,left_u,left_v,right_u,right_v," + columns + "\n",
          [&](std::string& text) {
            for (const PairCapture& c : list) {
              text += fmt::format(
                  "{},{},{},{}\n", mm(c.touch.p_H), mm(c.shown_D),
                  c.dots ? fmt::format("{},{},{},{}", c.dots->left.u, c.dots->left.v, c.dots->right.u, c.dots->right.v)
                         : ",,,",
                  joints(c.touch.reading));
            }
          });
  };
  pairs("register.csv", captures.registration);
  pairs("verify.csv", captures.verification);
  const auto stream = [&](const char* name, const Stream& s) {
    write(name, !s.t.empty(), "t_s,x_mm,y_mm,z_mm\n", [&](std::string& text) {
      for (std::size_t i = 0; i < s.t.size(); ++i) text += fmt::format("{},{}\n", s.t[i], mm(s.p[i]));
    });
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
