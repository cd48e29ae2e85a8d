// Plots as SVG, without script. Colours: the style sheet.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/markup.h"

namespace typodont::session {

/// Converts a number to text, for example "3.14" or "3,14".
using NumberText = std::function<std::string(double value, int decimals)>;

/// Step between the marks of an axis: 1, 2 or 5 times a power of ten, for about `count` marks up to `top`.
double nice_step(double top, int count);
/// Number of decimals for marks with this step.
int decimals_for(double step);

/// Least, mean and greatest value of a quantity in each bin of time.
struct Series {
  std::vector<double> least, mean, greatest;  // for each bin; NaN: no data
};

struct TimePlot {
  double t0 = 0, t1 = 1;  // s, begin and end of the time axis
  std::string unit;
  std::string label;  // description of the plot for screen readers
  std::string time_label;
  std::string css;  // CSS class of the curve: "force", "depth", …
  struct Mark {
    double t;
    std::string text;
    std::string css;  // CSS class of the mark: "fault", "tool", …
  };
  std::vector<Mark> marks;
};
std::string time_plot(const TimePlot& plot, const Series& series, const NumberText& number);

/// A strip of coloured intervals. `css[i]`: class of interval i; empty: not drawn.
std::string strip(const std::vector<std::string>& css, const std::string& label);

/// A histogram, logarithmic axes. `edges`: one more than `counts`.
std::string histogram(const std::vector<double>& edges, const std::vector<double>& counts, const std::string& unit,
                      const std::string& label, const NumberText& number);

/// Plots one value per session, with the target as a line. NaN: unknown.
std::string session_plot(const std::vector<double>& values, std::optional<double> target, const std::string& label,
                         const NumberText& number);

}  // namespace typodont::session
