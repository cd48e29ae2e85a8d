// The report's parts about implant surgery (phases, drilled hole, forces) and about measured pockets.
#include <algorithm>
#include <cmath>

#include "engine/base/units.h"
#include "engine/session/page/page.h"

namespace typodont::session {

namespace {

constexpr double kMinNoted = 0.05;  // s; warnings shown for a shorter time are not reported

}  // namespace

void Page::implant() {
  if (!input_.implant) return;
  const ImplantMeasures& m = *input_.implant;
  begin_section("implant", "implant.title", Length::kLong);
  put("<p class=\"soft\">{}</p>\n", say("implant.models"));
  begin_table("implant", {say("implant.phase"), say("implant.state"), say("time"), say("score.force_max_N"),
                          say("implant.depth"), say("implant.temperature"), say("implant.notes")});
  const auto language_index = static_cast<std::size_t>(language);
  const auto name_in = [&](const ImplantPhaseMeasures& phase) {
    return phase.name[language_index].empty() ? phase.name[0] : phase.name[language_index];
  };
  for (std::size_t i = 0; i < m.phases.size(); ++i) {
    const ImplantPhaseMeasures& phase = m.phases[i];
    std::string notes;
    for (std::size_t n = 1; n < phase.noted.size(); ++n) {
      if (phase.noted[n] < kMinNoted) continue;
      notes += fmt::format("{}{} ({} s)", notes.empty() ? "" : ", ",
                           say(fmt::format("implant.note.{}", name_of(static_cast<ImplantNote>(n)))),
                           number(phase.noted[n], 1));
    }
    const bool begun = phase.began >= 0;
    put("<tr><th scope=\"row\">{}. {}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        i + 1, escaped(name_in(phase)),
        say(phase.done      ? "implant.done"
            : phase.skipped ? "implant.skipped"
                            : "implant.open"),
        begun && phase.ended > phase.began ? quantity(phase.ended - phase.began, "s") : "–",
        begun ? quantity(phase.force_max, "N") : "–", phase.depth > 0 ? quantity(phase.depth * 1e3, "mm") : "–",
        begun ? quantity(phase.hottest, "°C") : "–", notes.empty() ? "–" : escaped(notes));
  }
  end_table();
  for (std::size_t i = 0; i < m.phases.size(); ++i) {
    const ImplantPhaseMeasures& phase = m.phases[i];
    const std::size_t n = phase.force.along.size();
    if (n < 2) continue;
    Series series;
    double greatest = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const double along = std::abs(static_cast<double>(phase.force.along[k])),
                   across = static_cast<double>(phase.force.across[k]);
      series.least.push_back(std::min(along, across));
      series.mean.push_back(along);
      series.greatest.push_back(std::max(along, across));
      greatest = std::max(greatest, series.greatest.back());
    }
    TimePlot plot;
    plot.t1 = phase.force.span * static_cast<double>(n);
    plot.unit = "N";
    plot.css = "force";
    plot.time_label = say("time_axis");
    plot.label = fmt::format("{}: {}", name_in(phase), quantity(greatest, "N"));
    put("<h3>{}. {}</h3>\n<div class=\"scroll\">{}</div>\n", i + 1, escaped(name_in(phase)),
        time_plot(plot, series, number_text()));
  }
  end_section();
}

void Page::probing() {
  if (!input_.explore || input_.explore->sites.empty() || !task_) return;
  begin_section("probing", "probing.title");
  begin_table("probing", {say("probing.site"), say("probing.reading"), say("probing.depth"), say("probing.force")});
  for (std::size_t i = 0; i < input_.explore->sites.size(); ++i) {
    const SiteReading& site = input_.explore->sites[i];
    const bool read = site.reading >= 0;
    put("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        escaped(task_->site_names.at(i).in(language)), read ? quantity(site.reading * 1e3, "mm") : "–",
        quantity(site.depth * 1e3, "mm"), read ? quantity(site.force, "N") : "–");
  }
  end_table();
  end_section();
}

}  // namespace typodont::session
