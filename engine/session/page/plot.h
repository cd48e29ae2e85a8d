// Plots as inline SVG: no script, colours from the page's style sheet.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/markup.h"

namespace typodont::session {

/// Formats a number with `decimals` decimals: "3.14" or "3,14".
using NumberText = std::function<std::string(double value, int decimals)>;

/// A round step (1, 2 or 5 times a power of ten) that gives about `count` marks on an axis up to `top`.
double nice_step(double top, int count);
/// Number of decimals that distinguishes marks with this step.
int decimals_for(double step);

/// A quantity over time in bins: the band from the smallest to the largest value, and the mean.
struct Series {
  std::vector<double> least, mean, greatest;  // one value per bin; NaN: no data
};

struct TimePlot {
  double t0 = 0, t1 = 1;  // s
  std::string unit;
  std::string label;  // description for screen readers
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

/// A band of coloured intervals, e.g. for the touched tissue. `css[i]` is the class of bin i; "": the bin stays
/// empty.
std::string strip(const std::vector<std::string>& css, const std::string& label);

/// Histogram of counts per bin; `edges` has one more entry than `counts`. Both axes are logarithmic.
std::string histogram(const std::vector<double>& edges, const std::vector<double>& counts, const std::string& unit,
                      const std::string& label, const NumberText& number);

/// Plot of one value per session, with the target as a line. NaN: the value of that session is unknown.
std::string session_plot(const std::vector<double>& values, std::optional<double> target, const std::string& label,
                         const NumberText& number);

}  // namespace typodont::session
