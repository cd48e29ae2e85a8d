#include "engine/app/bench/performance_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "engine/app/bench/page_text.h"
#include "engine/app/bench/plot.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/markup.h"

namespace typodont {

namespace {

bool positive(double v) {
  return std::isfinite(v) && v > 0;
}

/// Formats a duration, for example as "3.2 µs".
std::string duration(double ns) {
  if (!std::isfinite(ns)) return "";
  for (const auto& [unit, scale] : {std::pair{"s", 1e9}, {"ms", 1e6}, {"µs", 1e3}})
    if (ns >= scale) return fmt::format("{:.3g} {}", ns / scale, unit);
  return fmt::format("{:.3g} ns", ns);
}

/// Plots the error against the time, for the rows that have both. Rows share one plot if their errors have the same
/// unit and their times belong to the same kind of work (for example "per tick").
std::vector<Plot> work_precision(const std::vector<BenchRow>& rows) {
  std::map<std::pair<std::string, std::string>, Plot> plots;
  for (const BenchRow& r : rows) {
    if (!positive(r.error) || !positive(r.time_ns)) continue;
    Plot& plot = plots[{r.error_unit, r.per}];
    plot.title = "error against time";
    plot.x_label = fmt::format("time per {}, ns", r.per);
    plot.y_label = fmt::format("error, {}", r.error_unit);
    plot.of(r.name).points.push_back({r.time_ns, r.error, r.knob});
  }
  std::vector<Plot> out;
  for (auto& [units, plot] : plots) {
    std::size_t points = 0;
    for (const PlotSeries& s : plot.series) points += s.points.size();
    if (points >= 2) out.push_back(std::move(plot));
  }
  return out;
}

/// Plots the time against the problem size, for the rows that vary this size.
std::vector<Plot> growth(const std::vector<BenchRow>& rows) {
  std::map<std::string, Plot> plots;
  for (const BenchRow& r : rows) {
    if (!positive(r.size) || !positive(r.time_ns) || !std::isfinite(growth_exponent(rows, r.name))) continue;
    Plot& plot = plots[r.size_unit];
    plot.title = "growth";
    plot.x_label = r.size_unit;
    plot.y_label = "time, ns";
    const std::string name = fmt::format("{} (slope {:.2f})", r.name, growth_exponent(rows, r.name));
    plot.of(name).points.push_back({r.size, r.time_ns, r.knob});
  }
  std::vector<Plot> out;
  for (auto& [unit, plot] : plots) out.push_back(std::move(plot));
  return out;
}

/// Plots the rows whose measured quantity is not a time: the measured quantity against the size. Example: the critical
/// stiffness against the servo rate.
std::vector<Plot> laws(const std::vector<BenchRow>& rows) {
  std::map<std::pair<std::string, std::string>, Plot> plots;
  for (const BenchRow& r : rows) {
    if (std::isfinite(r.time_ns) || !positive(r.size) || !positive(r.error)) continue;
    Plot& plot = plots[{r.error_unit, r.size_unit}];
    plot.title = "law";
    plot.x_label = r.size_unit;
    plot.y_label = r.error_unit;
    plot.of(r.name).points.push_back({r.size, r.error, r.knob});
  }
  std::vector<Plot> out;
  for (auto& [units, plot] : plots) out.push_back(std::move(plot));
  return out;
}

std::string table(const std::vector<BenchRow>& rows) {
  std::string out =
      "| case | parameters | error | time | unit of work | ratio | compared with |\n|---|---|---|---|---|---|---|\n";
  for (const BenchRow& r : rows) {
    out +=
        fmt::format("| {} | {} | {} | {} | {} | {} | {} |\n", r.name, r.knob,
                    std::isfinite(r.error) ? fmt::format("{:.3g} {}", r.error, r.error_unit) : "", duration(r.time_ns),
                    r.per, std::isfinite(r.ratio) ? fmt::format("{:.3g}", r.ratio) : "", r.baseline);
  }
  return out;
}

/// A method of another program, which is compared with this program. `begins`: the first characters of
/// BenchRow::baseline in the rows of this comparison.
struct Rival {
  std::string_view begins;
  // true: the row's name states the other program's method, and the baseline is the method of this program
  bool in_name;
};
constexpr Rival kRivals[] = {{"voxel penalty", false}, {"csgDifference", false},     {"volumeToMesh", false},
                             {"OpenCV", false},        {"cross-correlation", false}, {"the servo's slide", true}};

}  // namespace

std::string slower_table(std::span<const MeasuredPart> parts) {
  std::string out;
  for (const MeasuredPart& m : parts) {
    for (const BenchRow& r : m.rows) {
      const auto rival = std::find_if(std::begin(kRivals), std::end(kRivals),
                                      [&](const Rival& each) { return r.baseline.starts_with(each.begins); });
      if (rival == std::end(kRivals) || !positive(r.time_ns) || !positive(r.ratio)) continue;
      const double factor = rival->in_name ? 1 / r.ratio : r.ratio;
      if (factor <= 1) continue;
      const double other = r.time_ns / r.ratio;
      const auto [ours, theirs] = rival->in_name ? std::pair{other, r.time_ns} : std::pair{r.time_ns, other};
      out += fmt::format("| {} | {} | {} | {} | {:.2g} | {} |\n", r.name, r.knob, duration(ours), duration(theirs),
                         factor, rival->in_name ? "the method in the first column" : r.baseline);
    }
  }
  if (out.empty()) return "No measured method of another program is faster than this program.\n";
  return "| case | parameters | this program | other method | factor | other method is |\n|---|---|---|---|---|---|\n" +
         out;
}

double growth_exponent(const std::vector<BenchRow>& rows, const std::string& name) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const BenchRow& r : rows) {
    if (r.name != name || !positive(r.size) || !positive(r.time_ns)) continue;
    const double lx = std::log(r.size), ly = std::log(r.time_ns);
    n += 1, sx += lx, sy += ly, sxx += lx * lx, sxy += lx * ly;
  }
  const double spread = n * sxx - sx * sx;
  return n >= 2 && spread > 1e-9 ? (n * sxy - sx * sy) / spread : std::nan("");
}

void write_performance_page(const std::filesystem::path& file, const std::vector<MeasuredPart>& parts,
                            const std::string& machine) {
  if (parts.size() == 1 && parts.front().part->write_page) {
    parts.front().part->write_page(file, parts.front().rows, machine);
    return;
  }
  const std::string folder = file.stem().string();
  std::error_code code;
  std::filesystem::create_directories(file.parent_path() / folder, code);
  if (code) throw Error(file.string(), "", code.message(), "a place where files can be made");
  std::string page = fmt::format(
      "# Performance: error against time\n\nThe command `./run bench` writes this page, so that no value is typed by "
      "hand. Measured on: {}. Times are CPU times of the measuring thread unless a row says otherwise. The ratio in a "
      "row is the row's time divided by the time of another method or by a measured lower bound (floor) of the same "
      "run.\n",
      machine);
  page +=
      "\n## Where another method is faster\n\nThe table lists all rows of this page in which a method of another "
      "program needs less time than this program. The tables in the sections below contain the errors of both "
      "methods.\n\n" +
      slower_table(parts);
  for (const MeasuredPart& m : parts) {
    page += fmt::format("\n## {}\n\n{}\n\n", m.part->title, m.part->what);
    if (m.part->write_page) {
      const std::string own = fmt::format("{}.md", m.part->name);
      m.part->write_page(file.parent_path() / own, m.rows, machine);
      page += fmt::format("On [its own page]({}).\n", own);
      continue;
    }
    int number = 0;
    for (const auto& plots : {work_precision(m.rows), growth(m.rows), laws(m.rows)}) {
      for (const Plot& plot : plots) {
        const std::string name = fmt::format("{}_{}.svg", m.part->name, ++number);
        write_file_atomically(file.parent_path() / folder / name, svg(plot), FileKind::kDrawing);
        page += fmt::format("![{}: {} against {}]({}/{})\n\n", plot.title, plot.y_label, plot.x_label, folder, name);
      }
    }
    page += m.part->table ? m.part->table(m.rows) : table(m.rows);
  }
  write_page(file, page);
}

}  // namespace typodont
