// Writes the result of an experiment as one HTML file without scripts; drawings are SVG.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/app/experiment/experiment.h"
#include "engine/base/markup.h"

namespace typodont {

namespace {

constexpr const char* kStyle =
    "body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#1d2330;"
    "background:#fff}svg{max-width:100%;height:auto}table{border-collapse:collapse;font-variant-numeric:tabular-nums}"
    "td,th{border:1px solid #c9ced8;padding:.25rem .6rem;text-align:left}figure{margin:1rem 0}"
    "figcaption{color:#4a5263}text{font:13px system-ui,sans-serif;fill:#1d2330}";

/// Axes and labels of a plot; converts values to pixels.
class Frame {
 public:
  static constexpr double kLeft = 64, kTop = 16, kWidth = 640, kHeight = 260;

  Frame(double x0, double x1, double y0, double y1, bool log_y = false)
      : x0_(x0), x1_(x1), y0_(y0), y1_(y1), log_y_(log_y) {}

  double x(double value) const { return kLeft + kWidth * (value - x0_) / (x1_ - x0_); }
  double y(double value) const {
    const double fraction = log_y_ ? std::log(value / y0_) / std::log(y1_ / y0_) : (value - y0_) / (y1_ - y0_);
    return kTop + kHeight * (1 - fraction);
  }
  void line(double ax, double ay, double bx, double by, const char* style) {
    marks_ += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>", x(ax), y(ay), x(bx),
                          y(by), style);
  }
  void point(double ax, double ay, double radius, const char* style) {
    marks_ += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" {}/>", x(ax), y(ay), radius, style);
  }
  void curve(const std::vector<std::pair<double, double>>& points, const char* style) {
    std::string path;
    for (const auto& [ax, ay] : points) path += fmt::format("{:.1f},{:.1f} ", x(ax), y(ay));
    marks_ += fmt::format("<polyline fill=\"none\" {} points=\"{}\"/>", style, path);
  }
  void x_label(double value, const std::string& text) {
    marks_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>", x(value),
                          kTop + kHeight + 18, text);
  }
  void y_label(double value, const std::string& text) {
    line(x0_, value, x1_, value, "stroke=\"#e3e6ec\"");
    marks_ +=
        fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>", kLeft - 8, y(value) + 4, text);
  }
  std::string svg(const std::string& title, const std::string& x_title) const {
    return fmt::format(
        "<svg viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" role=\"img\" aria-label=\"{2}\"><rect x=\"{3}\" "
        "y=\"{4}\" width=\"{5}\" height=\"{6}\" fill=\"none\" stroke=\"#8b93a3\"/>{7}<text x=\"{8:.1f}\" y=\"{9:.1f}\" "
        "text-anchor=\"middle\">{10}</text></svg>",
        kLeft + kWidth + 24, kTop + kHeight + 48, escaped(title), kLeft, kTop, kWidth, kHeight, marks_,
        kLeft + kWidth / 2, kTop + kHeight + 40, escaped(x_title));
  }

 private:
  double x0_, x1_, y0_, y1_;
  bool log_y_;
  std::string marks_;
};

std::string figure(const std::string& svg, const std::string& caption) {
  return fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n", svg, escaped(caption));
}

std::string staircase_figure(const ExperimentResult& result, const std::vector<AnsweredTrial>& answered) {
  double least = 1e300, most = 0;
  for (const AnsweredTrial& a : answered) {
    least = std::min(least, a.trial.level), most = std::max(most, a.trial.level);
  }
  const std::string unit(unit_of(result.question));
  Frame frame(0, result.trials + 1.0, least / 1.3, most * 1.3, /*log_y=*/true);
  for (double power = std::pow(10, std::floor(std::log10(least))); power <= most; power *= 10)
    for (const double at : {power, 2 * power, 5 * power})
      if (at >= least / 1.3 && at <= most * 1.3) frame.y_label(at, fmt::format("{:g} {}", at, unit));
  const int stride = std::max(1, result.trials / 10);
  for (int i = stride; i <= result.trials; i += stride) frame.x_label(i, fmt::format("{}", i));
  std::vector<std::pair<double, double>> path;
  for (const AnsweredTrial& a : answered) path.emplace_back(a.trial.number, a.trial.level);
  frame.curve(path, "stroke=\"#8b93a3\"");
  for (const AnsweredTrial& a : answered)
    frame.point(a.trial.number, a.trial.level, 4,
                a.right() ? "fill=\"#0b6bcb\"" : "fill=\"#fff\" stroke=\"#b3261e\" stroke-width=\"2\"");
  if (result.settled_level > 0)
    frame.line(0, result.settled_level, result.trials + 1, result.settled_level,
               "stroke=\"#1d2330\" stroke-dasharray=\"5 4\"");
  return figure(frame.svg("Difference shown in each trial", "trial"),
                "The staircase: the difference shown in each trial, on a logarithmic scale. Filled: a right answer; "
                "open: a wrong one. Dashed: where the staircase settled.");
}

std::string function_figure(const ExperimentResult& result, const std::vector<AnsweredTrial>& answered) {
  struct Cell {
    int count = 0, second = 0;
  };
  std::map<double, Cell> cells;
  double most = 0;
  for (const AnsweredTrial& a : answered) {
    const double difference = a.trial.greater_second ? a.trial.level : -a.trial.level;
    Cell& cell = cells[difference];
    ++cell.count, cell.second += a.answer == Answer::kSecond;
    most = std::max(most, a.trial.level);
  }
  const PsychometricFit& fit = *result.fit;
  const std::string unit(unit_of(result.question));
  Frame frame(-1.1 * most, 1.1 * most, -0.04, 1.04);
  for (const double fraction : {0.0, 0.25, 0.5, 0.75, 1.0})
    frame.y_label(fraction, fmt::format("{:.0f} %", 100 * fraction));
  for (const double at : {-most, -most / 2, 0.0, most / 2, most}) frame.x_label(at, fmt::format("{:.3g}", at));
  for (const double jnd : {-fit.jnd.value, fit.jnd.value})
    if (std::abs(jnd) < most) frame.line(jnd, 0, jnd, 1, "stroke=\"#1d2330\" stroke-dasharray=\"5 4\"");
  std::vector<std::pair<double, double>> curve;
  for (int i = -100; i <= 100; ++i) curve.emplace_back(1.1 * most * i / 100, fit.function.second(1.1 * most * i / 100));
  frame.curve(curve, "stroke=\"#0b6bcb\" stroke-width=\"2\"");
  for (const auto& [difference, cell] : cells)
    frame.point(difference, static_cast<double>(cell.second) / cell.count, 2 + std::sqrt(4.0 * cell.count),
                "fill=\"#0b6bcb\" fill-opacity=\"0.35\" stroke=\"#0b6bcb\"");
  return figure(frame.svg("Answers and fitted psychometric function", "second minus first, " + unit),
                "How often the second stimulus was called the greater one. Circles: answers, larger where there were "
                "more trials; line: the fit; dashed: the just-noticeable difference.");
}

std::string row(std::string_view name, const std::string& value, const std::string& interval = "") {
  return fmt::format("<tr><th>{}</th><td>{}</td><td>{}</td></tr>\n", name, value, interval);
}
std::string interval_of(const Estimate& e, double scale = 1) {
  if (!std::isfinite(e.high)) return fmt::format("{:.3g} or more", scale * e.low);
  return fmt::format("{:.3g} to {:.3g}", scale * e.low, scale * e.high);
}

}  // namespace

std::string page_of(const ExperimentPlan& plan, const ExperimentResult& result,
                    const std::vector<AnsweredTrial>& answered, const std::string& title) {
  const std::string unit(unit_of(result.question));
  std::string page = page_head(title, kStyle);
  page += fmt::format("<p>{} {} two-alternative trials, order random (seed {}).</p>\n",
                      escaped(words_of(plan.question)), result.trials, plan.seed);
  page += "<table><tr><th></th><th>estimate</th><th>95 % interval</th></tr>\n";
  if (result.fit) {
    const PsychometricFit& fit = *result.fit;
    page += row("just-noticeable difference, " + unit,
                std::isfinite(fit.jnd.high) ? fmt::format("{:.3g}", fit.jnd.value) : "not determined",
                interval_of(fit.jnd));
    page += row("bias by the order, " + unit, fmt::format("{:.3g}", fit.bias.value), interval_of(fit.bias));
    page += row("lapses, %", fmt::format("{:.1f}", 100 * fit.function.lapse));
    page += row("right answers, %", fmt::format("{:.1f}", 100.0 * result.right / result.trials));
    if (result.settled_level > 0)
      page += row(fmt::format("staircase, {:.1f} % right, {}", 100 * result.target, unit),
                  fmt::format("{:.3g}", result.settled_level));
  } else if (result.trials > 0) {
    page += row(fmt::format("chose {} over {}, %", escaped(result.models[1]), escaped(result.models[0])),
                fmt::format("{:.1f}", 100 * result.chosen.value), interval_of(result.chosen, 100));
    page += row("probability by chance", fmt::format("{:.3g}", result.chance));
  }
  if (result.trials > 0)
    page += row("answered \"second\", %", fmt::format("{:.1f}", 100 * result.second.value),
                interval_of(result.second, 100));
  page += "</table>\n";
  if (result.fit) page += staircase_figure(result, answered) + function_figure(result, answered);
  page += result.fit ? "<p>Fit: P(\"second\") = lapse / 2 + (1 − lapse) Φ((difference − bias) / width), by maximum "
                       "likelihood; intervals from the profile likelihood. At the just-noticeable difference, 0.674 "
                       "width, an observer without bias and lapses is right in 75 % of the trials.</p>\n"
                     : "<p>Intervals: Clopper and Pearson; probability by chance: two-sided binomial test.</p>\n";
  return page + "</body></html>\n";
}

}  // namespace typodont
