#include "engine/app/bench/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "engine/base/markup.h"

namespace typodont {

namespace {

// Palette of Okabe & Ito 2008, which colour-blind readers can distinguish.
constexpr std::array<const char*, 8> kColors{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                             "#e69f00", "#56b4e9", "#000000", "#8a8a8a"};

/// Range of a logarithmic axis, from a power of ten to another power of ten.
struct Decades {
  int first = 0, last = 1;
  int step() const { return (last - first + 7) / 8; }
  /// Returns the position of the value on the axis: 0 at the lower end, 1 at the upper end.
  double fraction(double v) const { return (std::log10(v) - first) / (last - first); }
};

/// Finds the smallest range of whole decades that contains all values.
Decades decades(const std::vector<Plot>& plots, double PlotPoint::*value) {
  double lo = INFINITY, hi = -INFINITY;
  for (const Plot& plot : plots) {
    for (const PlotSeries& s : plot.series)
      for (const PlotPoint& p : s.points) {
        lo = std::min(lo, std::log10(p.*value));
        hi = std::max(hi, std::log10(p.*value));
      }
  }
  if (!(lo <= hi)) return {};
  const int first = static_cast<int>(std::floor(lo - 0.05)), last = static_cast<int>(std::ceil(hi + 0.05));
  return {first, std::max(last, first + 1)};
}

/// Rectangle of one plot in a drawing, with the ranges of its axes.
struct Frame {
  double left, top, width, height;
  Decades across, up;
  double x(double v) const { return left + width * across.fraction(v); }
  double y(double v) const { return top + height * (1 - up.fraction(v)); }
};

std::string begin_svg(double width, double height, const Plot& plot) {
  return fmt::format(
      R"svg(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0:.0f} {1:.0f}" width="{0:.0f}" height="{1:.0f}" font-family="sans-serif" font-size="11" role="img" aria-label="{2}: {3} against {4}">
<rect width="100%" height="100%" fill="#fff"/>
)svg",
      width, height, escaped(plot.title), escaped(plot.y_label), escaped(plot.x_label));
}

std::string grid(const Frame& f) {
  std::string out;
  for (int d = f.across.first; d <= f.across.last; d += f.across.step())
    out += fmt::format(
        R"svg(<path d="M{0:.1f} {1:.1f}v{2:.1f}" stroke="#ddd"/><text x="{0:.1f}" y="{3:.1f}" text-anchor="middle">1e{4}</text>
)svg",
        f.x(std::pow(10, d)), f.top, f.height, f.top + f.height + 16, d);
  for (int d = f.up.first; d <= f.up.last; d += f.up.step())
    out += fmt::format(
        R"svg(<path d="M{0:.1f} {1:.1f}h{2:.1f}" stroke="#ddd"/><text x="{3:.1f}" y="{4:.1f}" text-anchor="end">1e{5}</text>
)svg",
        f.left, f.y(std::pow(10, d)), f.width, f.left - 6, f.y(std::pow(10, d)) + 4, d);
  return out;
}

std::string labels(const Frame& f, const std::string& across, const std::string& up) {
  return fmt::format(
      R"svg(<text x="{:.1f}" y="{:.1f}" text-anchor="middle" font-size="12">{}</text><text transform="translate({:.1f} {:.1f}) rotate(-90)" text-anchor="middle" font-size="12">{}</text>
)svg",
      f.left + f.width / 2, f.top + f.height + 36, escaped(across), f.left - 54, f.top + f.height / 2, escaped(up));
}

const char* fill_of(std::size_t index) {
  return index >= kColors.size() ? "#fff" : kColors[index % kColors.size()];
}

std::string curve(const Frame& f, const PlotSeries& s, std::size_t index) {
  const char* color = kColors[index % kColors.size()];
  std::string path, dots;
  for (const PlotPoint& p : s.points) {
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", f.x(p.x), f.y(p.y));
    dots += fmt::format(
        R"svg(<circle cx="{:.1f}" cy="{:.1f}" r="3.5" fill="{}" stroke="{}"><title>{}: {}</title></circle>)svg",
        f.x(p.x), f.y(p.y), fill_of(index), color, escaped(s.name), escaped(p.knob));
  }
  return fmt::format(R"svg(<path d="{}" fill="none" stroke="{}" stroke-width="1.5"/>)svg", path, color) + dots;
}

std::string legend_entry(double x, double y, const std::string& name, std::size_t index) {
  return fmt::format(
      R"svg(<circle cx="{:.1f}" cy="{:.1f}" r="4" fill="{}" stroke="{}"/><text x="{:.1f}" y="{:.1f}">{}</text>
)svg",
      x, y - 4, fill_of(index), kColors[index % kColors.size()], x + 10, y, escaped(name));
}

}  // namespace

PlotSeries& Plot::of(const std::string& name) {
  for (PlotSeries& s : series)
    if (s.name == name) return s;
  return series.emplace_back(PlotSeries{name, {}});
}

std::string svg(const Plot& plot) {
  constexpr double kLeft = 70, kTop = 16, kWidth = 430, kHeight = 300, kLegend = 400;
  const double height = std::max(kTop + kHeight + 50, kTop + 20.0 * static_cast<double>(plot.series.size()) + 20);
  const std::vector<Plot> one{plot};
  const Frame frame{kLeft, kTop, kWidth, kHeight, decades(one, &PlotPoint::x), decades(one, &PlotPoint::y)};
  std::string out =
      begin_svg(kLeft + kWidth + kLegend, height, plot) + grid(frame) + labels(frame, plot.x_label, plot.y_label);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    PlotSeries s = plot.series[i];
    std::sort(s.points.begin(), s.points.end(), [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
    out += curve(frame, s, i);
    out += legend_entry(kLeft + kWidth + 18, kTop + 12 + 20 * static_cast<double>(i), s.name, i);
  }
  return out + "</svg>\n";
}

std::string svg_panels(const std::vector<Plot>& panels) {
  constexpr double kLeft = 70, kTop = 24, kWidth = 220, kHeight = 180, kGapX = 62, kGapY = 76;
  constexpr std::size_t kColumns = 3;
  if (panels.empty()) return {};
  const std::size_t columns = std::min(kColumns, panels.size()), rows = (panels.size() + columns - 1) / columns;
  const double width = kLeft + static_cast<double>(columns) * (kWidth + kGapX) + 110;
  const double height = kTop + static_cast<double>(rows) * (kHeight + kGapY);
  const Decades across = decades(panels, &PlotPoint::x), up = decades(panels, &PlotPoint::y);
  std::string out = begin_svg(width, height, panels.front());
  for (std::size_t k = 0; k < panels.size(); ++k) {
    const double left = kLeft + static_cast<double>(k % columns) * (kWidth + kGapX);
    const double top = kTop + static_cast<double>(k / columns) * (kHeight + kGapY);
    const Frame frame{left, top, kWidth, kHeight, across, up};
    out += fmt::format(R"svg(<text x="{:.1f}" y="{:.1f}" font-weight="bold">{}</text>
)svg",
                       left, top - 8, escaped(panels[k].title));
    out += grid(frame) + labels(frame, panels.front().x_label, k % columns == 0 ? panels.front().y_label : "");
    for (std::size_t i = 0; i < panels[k].series.size(); ++i) out += curve(frame, panels[k].series[i], i);
  }
  for (std::size_t i = 0; i < panels.front().series.size(); ++i) {
    out += legend_entry(width - 110, kTop + 12 + 20 * static_cast<double>(i), panels.front().series[i].name, i);
  }
  return out + "</svg>\n";
}

}  // namespace typodont
