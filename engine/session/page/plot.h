// Plots as inline SVG: no script, colours from the page's style sheet.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/markup.h"

namespace typodont::session {

/// "3.14" or "3,14": with `decimals` places.
using NumberText = std::function<std::string(double value, int decimals)>;

/// Round steps (1, 2, 5 times a power of ten) for about `count` marks on an axis up to `top`.
double nice_step(double top, int count);
/// Decimals that tell marks of this step apart.
int decimals_for(double step);

/// A quantity over time in bins: the band from least to greatest, and the mean.
struct Series {
  std::vector<double> least, mean, greatest;  // one per bin; NaN: no data
};

struct TimePlot {
  double t0 = 0, t1 = 1;  // s
  std::string unit;
  std::string label;  // for screen readers
  std::string time_label;
  std::string css;  // class of band and line: "force", "depth", …
  struct Mark {
    double t;
    std::string text;
    std::string css;  // "fault", "tool", …
  };
  std::vector<Mark> marks;
};
std::string time_plot(const TimePlot& plot, const Series& series, const NumberText& number);

/// A band of coloured stretches, e.g. which tissue is touched. `css[i]` of every bin; "" leaves it empty.
std::string strip(const std::vector<std::string>& css, const std::string& label);

/// Counts per bin; `edges` has one more entry than `counts`. Logarithmic in both axes.
std::string histogram(const std::vector<double>& edges, const std::vector<double>& counts, const std::string& unit,
                      const std::string& label, const NumberText& number);

/// A value per session, with its target as a line. NaN: not known for that session.
std::string session_plot(const std::vector<double>& values, std::optional<double> target, const std::string& label,
                         const NumberText& number);

/// RFC 4648.
std::string base64(const std::vector<unsigned char>& bytes);

}  // namespace typodont::session
