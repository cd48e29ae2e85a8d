// Draws bench rows as SVG plots: both axes logarithmic, one colour per series.
#pragma once

#include <string>
#include <vector>

namespace typodont {

struct PlotPoint {
  double x, y;  // coordinates; both must be positive, because the axes are logarithmic
  std::string knob;
};
struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
};
struct Plot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;

  /// Returns the series of this name; creates the series if the plot has none.
  PlotSeries& of(const std::string& name);
};

/// Draws one plot with its legend. Each series is drawn as a line through its points, in the order of x.
std::string svg(const Plot& plot);

/// Draws several plots with the same series side by side. Each plot has its own title. All plots have the same axes,
/// whose labels are those of the first plot, and one legend together. The points of a series are joined in the given
/// order.
std::string svg_panels(const std::vector<Plot>& panels);

}  // namespace typodont
