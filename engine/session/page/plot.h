// Draws plots as SVG inside the page. They need no script, and the page's style sheet gives their colours.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/markup.h"

namespace typodont::session {

/// A function that formats a number with `decimals` decimals, for example "3.14" or "3,14".
using NumberText = std::function<std::string(double value, int decimals)>;

/// Returns a round distance between marks (1, 2 or 5 times a power of ten), with which an axis up to `top` has about
/// `count` marks.
double nice_step(double top, int count);
/// Returns the number of decimals that the labels of marks need if the marks are `step` apart.
int decimals_for(double step);

/// A quantity over time, in bins. The plot shows the range of the values and the mean in each bin.
struct Series {
  std::vector<double> least, mean, greatest;  // one value per bin; NaN if the bin has no data
};

struct TimePlot {
  double t0 = 0, t1 = 1;  // s, begin and end of the time axis
  std::string unit;
  std::string label;  // description of the plot for screen readers
  std::string time_label;
  std::string css;  // CSS class of band and line: "force", "depth", …
  struct Mark {
    double t;
    std::string text;
    std::string css;  // CSS class of the mark: "fault", "tool", …
  };
  std::vector<Mark> marks;
};
std::string time_plot(const TimePlot& plot, const Series& series, const NumberText& number);

/// Draws a strip of coloured intervals, for example for the touched tissue. `css[i]` is the style class of interval i;
/// an empty class leaves the interval empty.
std::string strip(const std::vector<std::string>& css, const std::string& label);

/// Draws a histogram of the counts per bin. `edges` contains the edges of the bins, so it has one more entry than
/// `counts`. Both axes are logarithmic.
std::string histogram(const std::vector<double>& edges, const std::vector<double>& counts, const std::string& unit,
                      const std::string& label, const NumberText& number);

/// Draws one value per session, and the target as a line. A value is NaN if it is unknown.
std::string session_plot(const std::vector<double>& values, std::optional<double> target, const std::string& label,
                         const NumberText& number);

}  // namespace typodont::session
