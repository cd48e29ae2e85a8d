#include "engine/session/page/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace typodont::session {

namespace {

constexpr double kWidth = 960, kLeft = 56, kRight = 22;
constexpr double kPlot = kWidth - kLeft - kRight;

/// A line across the plot with its value at the left.
std::string grid_line(double left, double right, double y, const std::string& value) {
  return fmt::format(
      "<line class=\"grid\" x1=\"{:.0f}\" y1=\"{:.1f}\" x2=\"{:.0f}\" y2=\"{:.1f}\"/>"
      "<text x=\"{:.0f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>",
      left, y, right, y, left - 6, y + 4, value);
}

/// A vertical axis from a round value below `low` to one above `top`.
class ValueAxis {
 public:
  ValueAxis(double low, double top, double bottom, double height)
      : step_(nice_step(top - low > 1e-9 ? top - low : 1.0, 4)),
        from_(std::floor(low / step_ + 1e-9) * step_),
        to_(std::max(step_, std::ceil(top / step_ - 1e-9) * step_)),
        bottom_(bottom),
        height_(height) {}
  /// Height of a value in the drawing.
  double operator()(double value) const { return bottom_ - height_ * (value - from_) / (to_ - from_); }
  std::string svg(double left, double right, const NumberText& number) const {
    std::string out;
    for (double v = from_; v <= to_ + 1e-9 * step_; v += step_)
      out += grid_line(left, right, (*this)(v), number(std::abs(v) < 1e-9 * step_ ? 0.0 : v, decimals_for(step_)));
    return out;
  }

 private:
  double step_, from_, to_, bottom_, height_;
};

std::string axis_of_time(double t0, double t1, double y, double top, const std::string& label,
                         const NumberText& number) {
  std::string out;
  const double step = nice_step(t1 - t0, 10);
  const int decimals = decimals_for(step);
  for (double t = std::ceil(t0 / step) * step; t <= t1 + 1e-9 * step; t += step) {
    const double x = kLeft + kPlot * (t - t0) / (t1 - t0);
    out += fmt::format(
        "<line class=\"grid\" x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{0:.1f}\" y2=\"{2:.1f}\"/>"
        "<text x=\"{0:.1f}\" y=\"{3:.1f}\" text-anchor=\"middle\">{4}</text>",
        x, top, y, y + 16, number(t, decimals));
  }
  out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>", kWidth - kRight, y + 32,
                     escaped(label));
  return out;
}

}  // namespace

double nice_step(double top, int count) {
  if (!(top > 0) || !std::isfinite(top)) return 1;
  const double raw = top / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= raw * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

int decimals_for(double step) {
  return std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, 9);
}

std::string time_plot(const TimePlot& plot, const Series& series, const NumberText& number) {
  constexpr double kTop = 10, kHeight = 150, kBottom = kTop + kHeight;
  double top = 0, low = 0;
  for (std::size_t i = 0; i < series.greatest.size(); ++i) {
    if (std::isnan(series.greatest[i])) continue;
    top = std::max(top, series.greatest[i]);
    low = std::min(low, series.least[i]);
  }
  const ValueAxis y_of(low, top, kBottom, kHeight);
  const auto x_of = [&](double bin) { return kLeft + kPlot * bin / static_cast<double>(series.mean.size()); };
  std::string out = fmt::format("<svg class=\"plot {}\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
                                plot.css, kWidth, kBottom + 38, escaped(plot.label));
  out += y_of.svg(kLeft, kWidth - kRight, number);
  out += axis_of_time(plot.t0, plot.t1, kBottom, kTop, plot.time_label, number);
  out +=
      fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" class=\"unit\">{}</text>", kLeft + 4, kTop + 12, escaped(plot.unit));

  // Draws each run of bins without gaps as one shape: the maxima forwards, the minima back. Then draws the mean.
  const std::size_t n = series.mean.size();
  for (std::size_t i = 0; i < n;) {
    if (std::isnan(series.mean[i])) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < n && !std::isnan(series.mean[end])) ++end;
    std::string band, line;
    for (std::size_t k = i; k < end; ++k) {
      const double x = x_of(static_cast<double>(k) + 0.5);
      band += fmt::format("{}{:.1f},{:.1f}", k == i ? "M" : "L", x, y_of(series.greatest[k]));
      line += fmt::format("{}{:.1f},{:.1f}", k == i ? "M" : "L", x, y_of(series.mean[k]));
    }
    for (std::size_t k = end; k-- > i;) {
      band += fmt::format("L{:.1f},{:.1f}", x_of(static_cast<double>(k) + 0.5), y_of(series.least[k]));
    }
    out += fmt::format("<path class=\"band\" d=\"{}Z\"/><path class=\"line\" d=\"{}\"/>", band, line);
    i = end;
  }
  for (const TimePlot::Mark& mark : plot.marks) {
    const double x = kLeft + kPlot * std::clamp((mark.t - plot.t0) / (plot.t1 - plot.t0), 0.0, 1.0);
    out += fmt::format(
        "<line class=\"mark {}\" x1=\"{:.1f}\" y1=\"{:.0f}\" x2=\"{:.1f}\" y2=\"{:.0f}\"><title>{}</title></line>",
        mark.css, x, kTop, x, kBottom, escaped(mark.text));
  }
  out += "</svg>";
  return out;
}

std::string strip(const std::vector<std::string>& css, const std::string& label) {
  std::string out = fmt::format(
      "<svg class=\"strip\" viewBox=\"0 0 {} 26\" role=\"img\" aria-label=\"{}\">"
      "<rect class=\"frame\" x=\"{}\" y=\"3\" width=\"{}\" height=\"20\"/>",
      kWidth, escaped(label), kLeft, kPlot);
  for (std::size_t i = 0; i < css.size();) {
    std::size_t end = i;
    while (end < css.size() && css[end] == css[i]) ++end;
    if (!css[i].empty()) {
      const double n = static_cast<double>(css.size());
      out += fmt::format("<rect class=\"{}\" x=\"{:.2f}\" y=\"3\" width=\"{:.2f}\" height=\"20\"/>", css[i],
                         kLeft + kPlot * static_cast<double>(i) / n, kPlot * static_cast<double>(end - i) / n);
    }
    i = end;
  }
  return out + "</svg>";
}

std::string histogram(const std::vector<double>& edges, const std::vector<double>& counts, const std::string& unit,
                      const std::string& label, const NumberText& number) {
  constexpr double kTop = 10, kHeight = 120, kBottom = kTop + kHeight;
  const double most = std::max(1.0, *std::max_element(counts.begin(), counts.end()));
  const double lg0 = std::log10(edges.front()), lg1 = std::log10(edges.back());
  const double decades = std::max(1.0, std::ceil(std::log10(most)));
  const auto x_of = [&](double v) { return kLeft + kPlot * (std::log10(v) - lg0) / (lg1 - lg0); };
  // The axis of counts begins at 10^-0.5, so that a bar of a single servo tick is visible.
  const auto y_of = [&](double c) { return kBottom - kHeight * (std::log10(c) + 0.5) / (decades + 0.5); };
  std::string out = fmt::format("<svg class=\"plot timing\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
                                kWidth, kBottom + 38, escaped(label));
  for (double d = 0; d <= decades; ++d) {
    const double c = std::pow(10.0, d);
    out += grid_line(kLeft, kWidth - kRight, y_of(c), number(c, 0));
  }
  for (double d = std::floor(lg0); d <= lg1; ++d) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double v = factor * std::pow(10.0, d);
      if (v < edges.front() * 0.999 || v > edges.back() * 1.001) continue;
      out += fmt::format(
          "<line class=\"grid\" x1=\"{0:.1f}\" y1=\"{1:.0f}\" x2=\"{0:.1f}\" y2=\"{2:.0f}\"/>"
          "<text x=\"{0:.1f}\" y=\"{3:.0f}\" text-anchor=\"middle\">{4}</text>",
          x_of(v), kTop, kBottom, kBottom + 16, number(v, v < 0.999 ? decimals_for(v) : 0));
    }
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] <= 0) continue;
    const double x0 = x_of(edges[i]), x1 = x_of(edges[i + 1]);
    out += fmt::format("<rect class=\"bar\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>", x0,
                       y_of(counts[i]), std::max(0.5, x1 - x0 - 1), kBottom - y_of(counts[i]));
  }
  out += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"end\">{}</text></svg>", kWidth - kRight,
                     kBottom + 32, escaped(unit));
  return out;
}

std::string session_plot(const std::vector<double>& values, std::optional<double> target, const std::string& label,
                         const NumberText& number) {
  constexpr double kW = 440, kL = 52, kR = 16, kTop = 12, kHeight = 110, kBottom = kTop + kHeight;
  double top = target.value_or(0), low = 0;
  for (const double v : values) {
    if (std::isnan(v)) continue;
    top = std::max(top, v);
    low = std::min(low, v);
  }
  const ValueAxis y_of(low, top, kBottom, kHeight);
  const auto x_of = [&](std::size_t i) {
    const double n = static_cast<double>(values.size());
    return kL + (kW - kL - kR) * (static_cast<double>(i) + 0.5) / n;
  };
  std::string out = fmt::format("<svg class=\"plot sessions\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
                                kW, kBottom + 22, escaped(label));
  out += y_of.svg(kL, kW - kR, number);
  if (target) {
    out += fmt::format("<line class=\"mark\" x1=\"{:.0f}\" y1=\"{:.1f}\" x2=\"{:.0f}\" y2=\"{:.1f}\"/>", kL,
                       y_of(*target), kW - kR, y_of(*target));
  }
  std::string line, dots;
  const std::size_t every = 1 + values.size() / 12;  // only every n-th, so that labels do not overlap
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i % every == 0) {
      out +=
          fmt::format("<text x=\"{:.1f}\" y=\"{:.0f}\" text-anchor=\"middle\">{}</text>", x_of(i), kBottom + 16, i + 1);
    }
    if (std::isnan(values[i])) continue;
    line += fmt::format("{}{:.1f},{:.1f}", line.empty() ? "M" : "L", x_of(i), y_of(values[i]));
    dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\"/>", x_of(i), y_of(values[i]));
  }
  out += fmt::format("<path class=\"line\" d=\"{}\"/>{}</svg>", line, dots);
  return out;
}

}  // namespace typodont::session
