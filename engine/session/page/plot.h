// SVG without script; colours come from the style sheet.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/markup.h"

namespace typodont::session {

/// For example "3.14" or "3,14".
using NumberText = std::function<std::string(double value, int decimals)>;

/// 1, 2 or 5 times a power of ten, for about `count` marks up to `top`.
double nice_step(double top, int count);
/// For marks `step` apart.
int decimals_for(double step);

/// In bins, with range and mean.
struct Series {
  std::vector<double> least, mean, greatest;  // per bin; NaN: no data
};

struct TimePlot {
  double t0 = 0, t1 = 1;  // s, begin and end of the time axis
  std::string unit;
  std::string label;  // description of the plot for screen readers
  std::string time_label;
  std::string css;  // "force", "depth", …
  struct Mark {
    double t;
    std::string text;
    std::string css;  // CSS class of the mark: "fault", "tool", …
  };
  std::vector<Mark> marks;
};
std::string time_plot(const TimePlot& plot, const Series& series, const NumberText& number);

/// `css[i]`: class of interval i; empty: nothing.
std::string strip(const std::vector<std::string>& css, const std::string& label);

/// `edges`: one more than `counts`. Both axes logarithmic.
std::string histogram(const std::vector<double>& edges, const std::vector<double>& counts, const std::string& unit,
                      const std::string& label, const NumberText& number);

/// The target as a line. NaN: unknown.
std::string session_plot(const std::vector<double>& values, std::optional<double> target, const std::string& label,
                         const NumberText& number);

}  // namespace typodont::session
