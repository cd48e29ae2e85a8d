#include "calibration/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/joint_solver.h"
#include "engine/base/markup.h"
#include "engine/base/units.h"

namespace typodont::calibration {

namespace {

// Plots one line per residual; outliers are red, and clipped lines have an arrowhead.
std::string residual_plot(const std::vector<double>& residuals, const std::vector<std::size_t>& rejected) {
  if (residuals.empty()) return "";
  const double w = 640, h = 130, left = 46, bottom = 20, top = 8;
  std::vector<double> kept;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    if (!std::binary_search(rejected.begin(), rejected.end(), i)) kept.push_back(residuals[i] * 1e3);
  }
  double ceiling = kept.empty() ? 1e-9 : 1.15 * *std::max_element(kept.begin(), kept.end());
  ceiling = std::max(ceiling, 1e-9);
  const double decade = std::pow(10, std::floor(std::log10(ceiling)));
  const double tick = decade * (ceiling / decade > 5 ? 2 : ceiling / decade > 2 ? 1 : 0.5);
  std::string svg = fmt::format(R"(<svg viewBox="0 0 {} {}" role="img" aria-label="residual of every touch">)", w, h);
  const auto y = [&](double v) { return h - bottom - (h - bottom - top) * std::min(1.0, v / ceiling); };
  for (double v = 0; v <= ceiling; v += tick) {
    svg += fmt::format(
        R"(<line x1="{}" x2="{}" y1="{:.1f}" y2="{:.1f}" class="grid"/><text x="{}" y="{:.1f}" class="tick" text-anchor="end">{:.3g}</text>)",
        left, w, y(v), y(v), left - 4, y(v) + 3.5, v);
  }
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const double x = left + (w - left - 6) * (static_cast<double>(i) + 0.5) / static_cast<double>(residuals.size());
    const bool out = std::binary_search(rejected.begin(), rejected.end(), i);
    svg += fmt::format(
        R"(<line x1="{0:.1f}" x2="{0:.1f}" y1="{1:.1f}" y2="{2:.1f}" class="{3}"><title>touch {4}: {5:.3f} mm{6}</title></line>)",
        x, h - bottom, y(residuals[i] * 1e3), out ? "out" : "stem", i + 1, residuals[i] * 1e3,
        out ? ", set aside" : "");
    if (out) svg += fmt::format(R"(<path d="M{:.1f} {:.1f}l-3 6h6z" class="head"/>)", x, y(residuals[i] * 1e3));
  }
  svg += fmt::format(R"(<text x="{}" y="{}" class="tick">touch →   residual in mm; red: set aside</text></svg>)", left,
                     h - 5);
  return svg;
}

// Colour scale from dark blue over teal to yellow, with even steps of lightness.
std::string colour(double s) {
  s = std::clamp(s, 0.0, 1.0);
  constexpr double kStops[5][3] = {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}};
  const double at = s * 4;
  const int i = std::min(3, static_cast<int>(at));
  const double f = at - i;
  const auto channel = [&](int c) {
    return static_cast<int>(std::lround(kStops[i][c] * (1 - f) + kStops[i + 1][c] * f));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", channel(0), channel(1), channel(2));
}

std::string row(std::string_view key, const std::string& value) {
  return fmt::format("<tr><th>{}</th><td>{}</td></tr>", key, value);
}

std::string section(std::string_view title, const std::string& lead, const std::string& body) {
  return fmt::format("<section><h2>{}</h2><p>{}</p>{}</section>\n", title, lead, body);
}

}  // namespace

std::string error_map_svg(const VerifyResult& result) {
  const int side = 9;
  const double cell = 20, gap = 34, top = 24;
  double worst = 1e-9;
  for (const MapPoint& p : result.map) worst = std::max(worst, glm::length(p.error_D));
  std::string svg = fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {} {}" role="img" aria-label="co-location error over the workspace" font-family="sans-serif">)",
      3 * (side * cell + gap) + 84, top + side * cell + 40);
  int panel = 0;
  for (const int level : {0, side / 2, side - 1}) {
    const double x0 = panel * (side * cell + gap) + 4;
    const double height = (result.map[static_cast<std::size_t>(level * side)].p_D.y) * 1e3;
    svg += fmt::format(R"(<text x="{}" y="14" font-size="12" fill="#445">y = {:.0f} mm</text>)", x0, height);
    for (int i = 0; i < side; ++i) {
      for (int k = 0; k < side; ++k) {
        const MapPoint& p = result.map[static_cast<std::size_t>(i + side * (level + side * k))];
        const double e = glm::length(p.error_D);
        svg += fmt::format(
            R"(<rect x="{:.1f}" y="{:.1f}" width="{}" height="{}" fill="{}"><title>({:.0f}, {:.0f}, {:.0f}) mm: {:.3f} ± {:.3f} mm</title></rect>)",
            x0 + i * cell, top + k * cell, cell - 1, cell - 1, colour(e / worst), p.p_D.x * 1e3, p.p_D.y * 1e3,
            p.p_D.z * 1e3, e * 1e3, p.sigma * 1e3);
      }
    }
    ++panel;
  }
  const double x = 3 * (side * cell + gap) + 4;
  for (int i = 0; i < 30; ++i) {
    svg += fmt::format(R"(<rect x="{}" y="{:.1f}" width="12" height="6.2" fill="{}"/>)", x, top + (29 - i) * 6,
                       colour(i / 29.0));
  }
  svg += fmt::format(
      R"(<text x="{}" y="{}" font-size="11" fill="#445">{:.3f} mm</text><text x="{}" y="{}" font-size="11" fill="#445">0</text>)",
      x + 16, top + 9, worst * 1e3, x + 16, top + 180);
  svg += fmt::format(
      R"(<text x="4" y="{}" font-size="11" fill="#445">x → right, down: z towards the user; systematic error of a smooth field through the fresh touches</text></svg>)",
      top + side * cell + 20);
  return svg;
}

std::string report_page(const BenchState& bench, const std::string& title) {
  std::string body;
  const auto mm = [](double metres) { return fmt::format("{:.3f} mm", metres * 1e3); };

  if (const auto& r = bench.verification) {
    body += fmt::format(R"(<p class="verdict {}">{}</p>)", r->pass ? "pass" : "fail", escaped(r->verdict));
    std::string table = "<table>";
    table += row("systematic error", mm(r->rms) + " rms, " + mm(r->worst) + " worst, known to ± " + mm(r->uncertainty));
    table += row("single touches", mm(r->raw_mean) + " mean, " + mm(r->raw_rms) + " rms, " + mm(r->raw_worst) +
                                       " worst, hand's noise included");
    table += row("noise of a touch", mm(r->noise) + " per axis");
    table += row("fresh points", fmt::format("{}, {} set aside", r->points, r->outliers.size()));
    body += section("Verify", "Points that no solver used. Remaining systematic error over the workspace:",
                    table + "</table>" + error_map_svg(*r) + residual_plot(r->residuals, r->outliers));
  }
  if (const auto& r = bench.registration) {
    std::string table = "<table>";
    const Pose& X = r->X_DH;
    table += row("X_DH", fmt::format("({:.3f}, {:.3f}, {:.3f}) mm, ({:.6f}, {:.6f}, {:.6f}, {:.6f}) wxyz", X.p.x * 1e3,
                                     X.p.y * 1e3, X.p.z * 1e3, X.R.w, X.R.x, X.R.y, X.R.z));
    table +=
        row("noise", mm(r->sigma) + " per axis from " + std::to_string(r->degrees_of_freedom) + " degrees of freedom");
    table += row("predicted target error", mm(r->predicted_tre_rms) + " rms over the workspace");
    table += row("pairs", fmt::format("{} used, {} set aside", r->inliers.size(), r->outliers.size()));
    if (r->degeneracy.defect != Defect::kNone) table += row("not to be trusted", escaped(r->degeneracy.reason));
    if (!r->rivals.empty())
      table += row("ambiguous", fmt::format("{} pairs agree on another motion", r->rivals.front().pairs.size()));
    body += section("Register", "The haptic base in the display, from points touched where they are seen.",
                    table + "</table>" + residual_plot(r->residuals, r->outliers));
  }
  if (const auto& r = bench.joint) {
    std::string table =
        "<table><tr><th>touches of</th><th>number</th><th>set aside</th><th>before</th><th>after</th></tr>";
    for (const auto& kind : r->kinds) {
      table += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>", kind.name, kind.touches,
                           kind.rejected, mm(kind.before_rms), mm(kind.after_rms));
    }
    table +=
        "</table><table>" +
        row("this user's offset",
            fmt::format("({:.2f}, {:.2f}, {:.2f}) ± ({:.2f}, {:.2f}, {:.2f}) mm, felt minus seen",
                        r->user_offset_W.x * 1e3, r->user_offset_W.y * 1e3, r->user_offset_W.z * 1e3,
                        r->user_offset_sigma.x * 1e3, r->user_offset_sigma.y * 1e3, r->user_offset_sigma.z * 1e3)) +
        row("interpupillary distance", mm(r->eyes.ipd) + " ± " + mm(r->ipd_sigma));
    for (const JointResult::Term& term : r->terms) table += row(term.name, size_in_words(term));
    table += "</table>";
    body += section("All touches together", "Arm, panel, mirror and eyes fitted to all captures together.", table);
  }
  if (const auto& r = bench.eyes_result) {
    body += section(
        "Eyes",
        escaped(r->not_determined.empty() ? "Alignments of a dot and the tip, one eye at a time." : r->not_determined),
        "<table>" + row("interpupillary distance", mm(r->eyes.ipd) + " ± " + mm(r->ipd_sigma)) +
            row("residual", mm(r->rms) + " rms across the line of sight") +
            (r->user_offset ? row("this user's offset",
                                  fmt::format("({:.2f}, {:.2f}, {:.2f}) mm, felt minus seen, from {} touches",
                                              r->user_offset->W.x * 1e3, r->user_offset->W.y * 1e3,
                                              r->user_offset->W.z * 1e3, r->user_offset->touches))
                            : "") +
            "</table>" + residual_plot(r->residuals, r->rejected));
  }
  if (const auto& r = bench.panel_result) {
    body += section("Panel", escaped(r->not_determined.empty() ? "Touches of the marks." : r->not_determined),
                    "<table>" +
                        row("size", mm(r->width) + " × " + mm(r->height) + " (± " + mm(r->width_sigma) + ", " +
                                        mm(r->height_sigma) + ")") +
                        row("residual", mm(r->rms) + " rms") + "</table>" + residual_plot(r->residuals, r->rejected));
  }
  if (const auto& r = bench.mirror_result) {
    body += section("Mirror", escaped(r->not_determined.empty() ? "Touches of its surface." : r->not_determined),
                    "<table>" + row("tilt known to", fmt::format("{:.3f}°", r->tilt_sigma / kDegree)) +
                        row("offset known to", mm(r->offset_sigma)) + row("residual", mm(r->rms) + " rms") +
                        "</table>" + residual_plot(r->residuals, r->rejected));
  }
  if (const auto& r = bench.arm_result) {
    std::string table = "<table><tr><th>parameter</th><th>before</th><th>after</th><th>±</th><th>determined</th></tr>";
    for (const ArmParameter& p : r->parameters) {
      const ArmUnit unit = arm_parameter_unit(p.name);
      table += fmt::format("<tr><td>{}</td><td>{:.4f}</td><td>{:.4f}</td><td>{:.4f} {}</td><td>{:.0f} %</td></tr>",
                           p.name, p.before / unit.si, p.after / unit.si, p.sigma / unit.si,
                           unit.si == kDegree ? "°" : unit.name, 100 * std::max(0.0, p.determined));
    }
    table += "</table><p>Not observable in these captures, and therefore unchanged: ";
    for (std::size_t i = 0; i < r->not_observable.size(); ++i) table += (i ? "; " : "") + escaped(r->not_observable[i]);
    table += r->not_observable.empty() ? "nothing.</p>" : ".</p>";
    if (!r->misfit.empty()) table += "<p>Not taken over: " + escaped(r->misfit) + ".</p>";
    body += section("Arm",
                    fmt::format("Distance of the tip from where it was held: {} before, {} after.", mm(r->before_rms),
                                mm(r->after_rms)),
                    table + residual_plot(r->residuals, r->rejected));
  }
  if (const auto& r = bench.delay) {
    body += section("Delay",
                    escaped(r->ambiguous ? r->reason : "Time between the arm and the display's tracker, from motion."),
                    "<table>" + row("delay", fmt::format("{:.4f} ± {:.4f} ms", r->delay * 1e3, r->sigma * 1e3)) +
                        row("clock skew", fmt::format("{:.2f} ± {:.2f} ppm", r->skew * 1e6, r->skew_sigma * 1e6)) +
                        row("rich enough for 0.1 ms", r->rich ? "yes" : "no") + "</table>");
  }
  return fmt::format(R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>{0}</title><style>
body{{font:15px/1.5 system-ui,sans-serif;color:#223;max-width:760px;margin:32px auto;padding:0 16px;background:#fcfcfd}}
h1{{font-size:24px;margin:0 0 8px}}h2{{font-size:17px;margin:28px 0 4px;border-top:1px solid #dde;padding-top:14px}}p{{margin:4px 0 8px}}
table{{border-collapse:collapse;margin:6px 0 10px;font-variant-numeric:tabular-nums}}th{{text-align:left;font-weight:600;color:#445}}th,td{{padding:2px 18px 2px 0}}
svg{{width:100%;height:auto}}.grid{{stroke:#e3e6ec}}.tick{{font-size:10px;fill:#667}}.stem{{stroke:#2b6cb0;stroke-width:1.4}}.out{{stroke:#c53030;stroke-width:1.4}}.head{{fill:#c53030}}
.verdict{{font-size:17px;font-weight:600;padding:10px 14px;border-radius:6px}}.pass{{background:#e3f6e8;color:#14532d}}.fail{{background:#fde8e8;color:#7f1d1d}}
</style></head><body><h1>{0}</h1>
{1}</body></html>
)",
                     escaped(title), body);
}

}  // namespace typodont::calibration
