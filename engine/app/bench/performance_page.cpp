#include "engine/app/bench/performance_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/markup.h"

namespace typodont {

namespace {

struct Point {
  double x, y;
  std::string knob;
};
struct Series {
  std::string name;
  std::vector<Point> points;
};
struct Plot {
  std::string title, x_label, y_label;
  std::vector<Series> series;
};

// Okabe & Ito 2008: told apart by colour-blind readers, too.
constexpr std::array<const char*, 8> kColors{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                             "#e69f00", "#56b4e9", "#000000", "#8a8a8a"};

bool positive(double v) {
  return std::isfinite(v) && v > 0;
}

/// "3.2 µs"
std::string duration(double ns) {
  if (!std::isfinite(ns)) return "";
  for (const auto& [unit, scale] : {std::pair{"s", 1e9}, {"ms", 1e6}, {"µs", 1e3}})
    if (ns >= scale) return fmt::format("{:.3g} {}", ns / scale, unit);
  return fmt::format("{:.3g} ns", ns);
}

Series& series_of(Plot& plot, const std::string& name) {
  for (Series& s : plot.series)
    if (s.name == name) return s;
  return plot.series.emplace_back(Series{name, {}});
}

/// Rows that have both an error and a time, in one plot for each pair of units.
std::vector<Plot> work_precision(const std::vector<BenchRow>& rows) {
  std::map<std::pair<std::string, std::string>, Plot> plots;
  for (const BenchRow& r : rows) {
    if (!positive(r.error) || !positive(r.time_ns)) continue;
    Plot& plot = plots[{r.error_unit, r.per}];
    plot.title = "error against time";
    plot.x_label = fmt::format("time per {}, ns", r.per);
    plot.y_label = fmt::format("error, {}", r.error_unit);
    series_of(plot, r.name).points.push_back({r.time_ns, r.error, r.knob});
  }
  std::vector<Plot> out;
  for (auto& [units, plot] : plots) {
    std::size_t points = 0;
    for (const Series& s : plot.series) points += s.points.size();
    if (points >= 2) out.push_back(std::move(plot));
  }
  return out;
}

/// Rows whose cost is asked for by size.
std::vector<Plot> growth(const std::vector<BenchRow>& rows) {
  std::map<std::string, Plot> plots;
  for (const BenchRow& r : rows) {
    if (!positive(r.size) || !positive(r.time_ns) || !std::isfinite(growth_exponent(rows, r.name))) continue;
    Plot& plot = plots[r.size_unit];
    plot.title = "growth";
    plot.x_label = r.size_unit;
    plot.y_label = "time, ns";
    const std::string name = fmt::format("{} (slope {:.2f})", r.name, growth_exponent(rows, r.name));
    series_of(plot, name).points.push_back({r.size, r.time_ns, r.knob});
  }
  std::vector<Plot> out;
  for (auto& [unit, plot] : plots) out.push_back(std::move(plot));
  return out;
}

/// Rows without a time: a quantity by size, e.g. a critical stiffness by servo rate.
std::vector<Plot> laws(const std::vector<BenchRow>& rows) {
  std::map<std::pair<std::string, std::string>, Plot> plots;
  for (const BenchRow& r : rows) {
    if (std::isfinite(r.time_ns) || !positive(r.size) || !positive(r.error)) continue;
    Plot& plot = plots[{r.error_unit, r.size_unit}];
    plot.title = "law";
    plot.x_label = r.size_unit;
    plot.y_label = r.error_unit;
    series_of(plot, r.name).points.push_back({r.size, r.error, r.knob});
  }
  std::vector<Plot> out;
  for (auto& [units, plot] : plots) out.push_back(std::move(plot));
  return out;
}

/// Decades that hold all values.
std::pair<int, int> decades(const Plot& plot, double Point::*value) {
  double lo = INFINITY, hi = -INFINITY;
  for (const Series& s : plot.series)
    for (const Point& p : s.points) {
      lo = std::min(lo, std::log10(p.*value));
      hi = std::max(hi, std::log10(p.*value));
    }
  const int first = static_cast<int>(std::floor(lo - 0.05)), last = static_cast<int>(std::ceil(hi + 0.05));
  return {first, std::max(last, first + 1)};
}

std::string svg(const Plot& plot) {
  constexpr double kLeft = 70, kTop = 16, kWidth = 430, kHeight = 300, kLegend = 400;
  const double height = std::max(kTop + kHeight + 50, kTop + 20.0 * static_cast<double>(plot.series.size()) + 20);
  const auto [x0, x1] = decades(plot, &Point::x);
  const auto [y0, y1] = decades(plot, &Point::y);
  const auto x = [&, a = x0, b = x1](double v) { return kLeft + kWidth * (std::log10(v) - a) / (b - a); };
  const auto y = [&, a = y0, b = y1](double v) { return kTop + kHeight * (1 - (std::log10(v) - a) / (b - a)); };
  std::string out = fmt::format(
      R"svg(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0:.0f} {1:.0f}" width="{0:.0f}" height="{1:.0f}" font-family="sans-serif" font-size="11" role="img" aria-label="{2}: {3} against {4}">
<rect width="100%" height="100%" fill="#fff"/>
)svg",
      kLeft + kWidth + kLegend, height, escaped(plot.title), escaped(plot.y_label), escaped(plot.x_label));
  const int x_step = (x1 - x0 + 7) / 8, y_step = (y1 - y0 + 7) / 8;
  for (int d = x0; d <= x1; d += x_step)
    out += fmt::format(
        R"svg(<path d="M{0:.1f} {1:.1f}v{2:.1f}" stroke="#ddd"/><text x="{0:.1f}" y="{3:.1f}" text-anchor="middle">1e{4}</text>
)svg",
        x(std::pow(10, d)), kTop, kHeight, kTop + kHeight + 16, d);
  for (int d = y0; d <= y1; d += y_step)
    out += fmt::format(
        R"svg(<path d="M{0:.1f} {1:.1f}h{2:.1f}" stroke="#ddd"/><text x="{3:.1f}" y="{4:.1f}" text-anchor="end">1e{5}</text>
)svg",
        kLeft, y(std::pow(10, d)), kWidth, kLeft - 6, y(std::pow(10, d)) + 4, d);
  out += fmt::format(
      R"svg(<text x="{:.1f}" y="{:.1f}" text-anchor="middle" font-size="12">{}</text><text transform="translate(16 {:.1f}) rotate(-90)" text-anchor="middle" font-size="12">{}</text>
)svg",
      kLeft + kWidth / 2, kTop + kHeight + 36, escaped(plot.x_label), kTop + kHeight / 2, escaped(plot.y_label));
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    Series s = plot.series[i];
    std::sort(s.points.begin(), s.points.end(), [](const Point& a, const Point& b) { return a.x < b.x; });
    const char* color = kColors[i % kColors.size()];
    const bool hollow = i >= kColors.size();
    std::string path;
    for (const Point& p : s.points) path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x(p.x), y(p.y));
    out += fmt::format(R"svg(<path d="{}" fill="none" stroke="{}" stroke-width="1.5"/>)svg", path, color);
    for (const Point& p : s.points)
      out += fmt::format(
          R"svg(<circle cx="{:.1f}" cy="{:.1f}" r="3.5" fill="{}" stroke="{}"><title>{}: {}</title></circle>)svg",
          x(p.x), y(p.y), hollow ? "#fff" : color, color, escaped(s.name), escaped(p.knob));
    const double ly = kTop + 12 + 20 * static_cast<double>(i);
    out += fmt::format(
        R"svg(<circle cx="{:.1f}" cy="{:.1f}" r="4" fill="{}" stroke="{}"/><text x="{:.1f}" y="{:.1f}">{}</text>
)svg",
        kLeft + kWidth + 18, ly - 4, hollow ? "#fff" : color, color, kLeft + kWidth + 28, ly, escaped(s.name));
  }
  return out + "</svg>\n";
}

std::string table(const std::vector<BenchRow>& rows) {
  std::string out = "| case | knob | error | time | per | ratio | to |\n|---|---|---|---|---|---|---|\n";
  for (const BenchRow& r : rows) {
    out +=
        fmt::format("| {} | {} | {} | {} | {} | {} | {} |\n", r.name, r.knob,
                    std::isfinite(r.error) ? fmt::format("{:.3g} {}", r.error, r.error_unit) : "", duration(r.time_ns),
                    r.per, std::isfinite(r.ratio) ? fmt::format("{:.3g}", r.ratio) : "", r.baseline);
  }
  return out;
}

}  // namespace

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
  const std::string folder = file.stem().string();
  std::error_code code;
  std::filesystem::create_directories(file.parent_path() / folder, code);
  if (code) throw Error(file.string(), "", code.message(), "a place where files can be made");
  std::string page = fmt::format(
      "# Performance: error against time\n\nMade by `./run bench`; not typed by hand. Measured on: {}. Times are "
      "processor time of the measuring "
      "thread unless a row says otherwise; ratios are taken within one run, against a peer's method or a measured "
      "floor.\n",
      machine);
  for (const MeasuredPart& m : parts) {
    page += fmt::format("\n## {}\n\n{}\n\n", m.part->title, m.part->what);
    int number = 0;
    for (const auto& plots : {work_precision(m.rows), growth(m.rows), laws(m.rows)}) {
      for (const Plot& plot : plots) {
        const std::string name = fmt::format("{}_{}.svg", m.part->name, ++number);
        write_file_atomically(file.parent_path() / folder / name, svg(plot), FileKind::kDrawing);
        page += fmt::format("![{}: {} against {}]({}/{})\n\n", plot.title, plot.y_label, plot.x_label, folder, name);
      }
    }
    page += table(m.rows);
  }
  write_file_atomically(file, page);
}

}  // namespace typodont
