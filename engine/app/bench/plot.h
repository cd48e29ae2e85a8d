// Plots of bench rows as SVG: both axes logarithmic, one colour per series.
#pragma once

#include <string>
#include <vector>

namespace typodont {

struct PlotPoint {
  double x, y;  // more than zero
  std::string knob;
};
struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
};
struct Plot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;

  /// The series of that name, made where there is none.
  PlotSeries& of(const std::string& name);
};

/// One plot with its legend. Points are joined by rising x.
std::string svg(const Plot& plot);

/// Several plots of the same series side by side, with common axes, each under its title, and one legend. Points are
/// joined in their order. Labels are those of the first plot.
std::string svg_panels(const std::vector<Plot>& panels);

}  // namespace typodont
