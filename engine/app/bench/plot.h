// Draws bench rows as SVG plots: both axes logarithmic, one colour per series.
#pragma once

#include <string>
#include <vector>

namespace typodont {

struct PlotPoint {
  double x, y;  // both must be positive
  std::string knob;
};
struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
};
struct Plot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;

  /// The series of that name; creates it if there is none.
  PlotSeries& of(const std::string& name);
};

/// One plot with its legend. Points are joined in the order of x.
std::string svg(const Plot& plot);

/// Several plots of the same series side by side, with common axes, a title each, and one legend. Points are joined in
/// their given order. Axis labels are those of the first plot.
std::string svg_panels(const std::vector<Plot>& panels);

}  // namespace typodont
