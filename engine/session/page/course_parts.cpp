#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>

#include "engine/base/units.h"
#include "engine/contract/safety_event.h"
#include "engine/session/page/page.h"
#include "engine/session/session_data.h"

namespace typodont::session {

namespace {

constexpr std::size_t kTableBins = 12;  // number of rows in the table beside a plot
constexpr std::size_t kMaxEvents = 200;

}  // namespace

void Page::frame_row(const FrameStream& frames, const char* key, std::string_view column, double scale,
                     const char* unit, bool least_is_worst) {
  std::vector<double> values = frames.column(column, scale);
  // Without measured values, there is nothing to show.
  if (values.empty() || (values.front() == 0 && values.back() == 0)) return;
  if (least_is_worst) std::reverse(values.begin(), values.end());
  const auto at = [&](double q) {
    return quantity(values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)], unit);
  };
  put("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td></tr>\n", say(key), at(0.5), at(0.99), at(1));
}

std::string Page::event_text(const SessionEvent& event) const {
  if (event.kind == EventKind::kTool) return fmt::format("{} ({})", tool_text(event.text, language), event.text);
  const std::string fault = "fault." + event.text;
  return event.kind == EventKind::kFault && has_text(fault) ? say(fault) : event.text;
}

std::vector<TimePlot::Mark> Page::marks() const {
  std::vector<TimePlot::Mark> result;
  for (const SessionEvent& e : session_.events()) {
    if (result.size() == kMaxEvents) break;
    const std::string kind(name_of(e.kind));
    result.push_back({to_seconds(e.t), fmt::format("{}: {}", say("event." + kind), event_text(e)), kind});
  }
  for (std::size_t i = 0; i < course_.faults.size(); ++i) {
    if (course_.faults[i].ticks == 0) continue;
    result.push_back({course_.faults[i].first, say("fault." + fault_names()[i].name), "fault"});
  }
  return result;
}

void Page::plot(const char* key, const char* css, const char* unit, const Series& s, int decimals, const char* note) {
  const std::size_t bins = s.mean.size(), rows = std::min(bins, kTableBins);
  // Mean and greatest value of some bins; no value if all are empty.
  const auto over = [&](std::size_t from, std::size_t to) -> std::optional<std::pair<double, double>> {
    double sum = 0, greatest = 0;
    std::size_t n = 0;
    for (std::size_t i = from; i < to; ++i) {
      if (std::isnan(s.mean[i])) continue;
      sum += s.mean[i];
      greatest = std::max(greatest, s.greatest[i]);
      ++n;
    }
    return n ? std::optional(std::pair(sum / static_cast<double>(n), greatest)) : std::nullopt;
  };
  const auto [mean, greatest] = over(0, bins).value_or(std::pair(0.0, 0.0));
  TimePlot p;
  p.t0 = course_.t0;
  p.t1 = course_.t1;
  p.unit = unit;
  p.css = css;
  p.time_label = say("time_axis");
  p.label = say("plot_alt", say(key), number(mean, decimals), unit, number(greatest, decimals), unit);
  p.marks = marks();
  put("<h3>{} ({})</h3>\n", say(key), unit);
  if (note) put("<p class=\"soft\">{}</p>\n", say(note));
  put("<div class=\"scroll\">{}</div>", time_plot(p, s, number_text()));
  // The values as a table, for readers without the plot.
  put("\n<details><summary>{}</summary><table><caption>{} ({})</caption><thead><tr><th scope=\"col\">{}</th><th "
      "scope=\"col\">{}</th>"
      "<th scope=\"col\">{}</th></tr></thead><tbody>",
      say("as_table"), say(key), unit, say("from_to"), say("mean"), say("greatest"));
  for (std::size_t r = 0; r < rows; ++r) {
    const std::size_t from = r * bins / rows, to = (r + 1) * bins / rows;
    const auto row = over(from, to);
    const auto t_of = [&](std::size_t bin) {
      return course_.t0 + (course_.t1 - course_.t0) * static_cast<double>(bin) / static_cast<double>(bins);
    };
    put("<tr><th scope=\"row\">{}–{}</th><td>{}</td><td>{}</td></tr>", number(t_of(from), 1), number(t_of(to), 1),
        row ? number(row->first, decimals) : "–", row ? number(row->second, decimals) : "–");
  }
  put("</tbody></table></details>\n");
}

void Page::over_time() {
  if (course_.count == 0) return;
  begin_section("course", "course", Length::kLong);
  plot("force", "force", "N", course_.force, 2);
  touched();
  plot("speed", "speed", "mm/s", course_.speed, 1, "speed_note");
  if (course_.max_spindle > 0) plot("spindle", "spindle", "krpm", course_.spindle, 0);
  plot("depth", "depth", "mm", course_.depth, 3, "depth_note");
  plot("removed_course", "removed", "mm³", course_.removed, 2);
  if (options_.input && options_.input->heat) {
    temperature("pulp_temperature", options_.input->heat->pulp_curve);
    temperature("bone_temperature", options_.input->heat->bone_curve);
  }
  end_section();
}

void Page::temperature(const char* key, const std::vector<float>& curve) {
  if (curve.empty()) return;
  const std::vector<double> values(curve.begin(), curve.end());
  plot(key, "depth", "°C", {values, values, values}, 1);
}

void Page::touched() {
  std::vector<std::string> css(course_.touched.size());
  std::array<std::uint64_t, kTissueCount> total{};
  std::uint64_t all = 0;
  for (std::size_t bin = 0; bin < css.size(); ++bin) {
    const auto& counts = course_.touched[bin];
    const auto most = std::max_element(counts.begin() + 1, counts.end());
    if (*most > 0) css[bin] = fmt::format("s-{}", name_of(static_cast<Tissue>(most - counts.begin())));
    for (std::size_t i = 1; i < kTissueCount; ++i) {
      total[i] += counts[i];
      all += counts[i];
    }
  }
  if (all == 0) return;
  std::vector<std::string> fractions;
  for (std::size_t i = 1; i < kTissueCount; ++i) {
    if (total[i] > 0) {
      fractions.push_back(fmt::format("{} {} %", tissue_text(i),
                                      number(100.0 * static_cast<double>(total[i]) / static_cast<double>(all), 0)));
    }
  }
  put("<h3>{}</h3>\n", say("touched"));
  put("<div class=\"scroll\">{}</div>\n",
      strip(css, fmt::format("{}: {}", say("touched"), fmt::join(fractions, ", "))));
  put("<ul class=\"legend\" aria-hidden=\"true\">");
  std::size_t k = 0;
  for (std::size_t i = 1; i < kTissueCount; ++i) {
    if (total[i] > 0)
      put("<li><span class=\"swatch s-{}\"></span>{}</li>", name_of(static_cast<Tissue>(i)), fractions[k++]);
  }
  put("</ul>\n");
}

void Page::faults() {
  if (course_.count == 0) return;
  begin_section("faults", "faults");
  if (course_.all_faults.ticks == 0) {
    put("<p>{}</p>\n", say("no_faults"));
    return end_section();
  }
  begin_table("faults", {say("fault"), say("how_often"), say("first_at")});
  for (std::size_t i = 0; i < course_.faults.size(); ++i) {
    const auto& f = course_.faults[i];
    if (f.ticks == 0) continue;
    put("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td></tr>\n", say("fault." + fault_names()[i].name),
        fault_times(f), number(f.first, 3));
  }
  end_table();
  end_section();
}

void Page::timing() {
  if (course_.cpu_us.empty() && !session_.loop()) return;
  begin_section("timing", "timing");
  cpu_times();
  if (session_.loop()) {
    loop_times(*session_.loop());
    real_time(*session_.loop());
  }
  sound_times();
  end_section();
}

void Page::loop_times(const LoopReport& loop) {
  const LoopTiming& t = loop.timing;
  const double fraction =
      100 * static_cast<double>(t.misses) / static_cast<double>(std::max<std::uint64_t>(t.ticks, 1));
  begin_table("timing", {"", say("median"), "99 %", three_nines(), say("worst")},
              say("loop_caption", t.ticks, t.misses, number(fraction, fraction > 0 && fraction < 0.01 ? 4 : 2),
                  number(static_cast<double>(t.worst_index) * to_seconds(t.period), 2)));
  const auto row = [&](const char* key, const DurationHistogram& h, Nanos worst) {
    // The quantile is the upper edge of a bin, so it may exceed the largest value; limit it.
    const auto us = [&](double q) { return number(std::min(h.quantile(q), static_cast<double>(worst)) / 1e3); };
    put("<tr><th scope=\"row\">{}</th><td>{} µs</td><td>{} µs</td><td>{} µs</td><td>{} µs</td></tr>\n", say(key),
        us(0.5), us(0.99), us(0.999), number(static_cast<double>(worst) / 1e3));
  };
  row("loop_work", t.work, t.worst_tick);
  row("loop_jitter", t.jitter, t.worst_jitter);
  end_table();
  int first = DurationHistogram::kBins, last = -1;
  for (int i = 0; i < DurationHistogram::kBins; ++i) {
    if (t.jitter.counts[static_cast<std::size_t>(i)] == 0) continue;
    first = std::min(first, i);
    last = i;
  }
  if (last < 0) return;
  // The axis shows at least one decade (27 bins), because a shorter axis may have no marks.
  first = std::max(0, std::min(first, last - 27));
  last = std::min(DurationHistogram::kBins - 1, std::max(last, first + 27));
  std::vector<double> edges{DurationHistogram::upper_edge(first) / 1e3 *
                            std::exp2(-1.0 / DurationHistogram::kPerOctave)},
      counts;
  for (int i = first; i <= last; ++i) {
    edges.push_back(DurationHistogram::upper_edge(i) / 1e3);
    counts.push_back(t.jitter.counts[static_cast<std::size_t>(i)]);
  }
  const auto us = [&](double q) {
    return number(std::min(t.jitter.quantile(q), static_cast<double>(t.worst_jitter)) / 1e3);
  };
  put("<div class=\"scroll\">{}</div>\n", histogram(edges, counts, "µs",
                                                    say("loop_jitter_alt", t.jitter.total(), us(0.5), us(0.99),
                                                        number(static_cast<double>(t.worst_jitter) / 1e3)),
                                                    number_text()));
}

void Page::real_time(const LoopReport& loop) {
  put("<h3>{}</h3>\n<dl class=\"list\">", say("realtime"));
  const auto entry = [&](const char* key, const std::string& value) { put("<dt>{}</dt><dd>{}</dd>", say(key), value); };
  for (const auto& [name, yes] : granted(loop.fifo, loop.pinned, loop.memory_locked))
    entry(name.data(), say(yes ? "realtime.yes" : "realtime.no"));
  if (loop.bearable_force > 0) {  // true only for a device with motors
    entry("motor_heat", say("motor_heat_value", number(100 * loop.worst_heat, 0)));
    std::vector<std::string> events;
    for (const auto& [event, name] : kSafetyEventNames) {
      if (loop.safety & bits(event)) events.push_back(say(fmt::format("safety.{}", name)));
    }
    entry("safety", events.empty() ? say("safety.none") : fmt::format("{}", fmt::join(events, "; ")));
  }
  put("</dl>\n");
}

void Page::cpu_times() {
  if (course_.cpu_us.empty()) return;
  std::vector<float>& us = course_.cpu_us;
  std::sort(us.begin(), us.end());
  const auto quantile = [&](double q) {
    return static_cast<double>(us[static_cast<std::size_t>(q * static_cast<double>(us.size() - 1) + 0.5)]);
  };
  const double period = 1e6 / session_.header().servo_rate;
  // The histogram has twelve bins per decade.
  const double lo = std::floor(std::log10(std::max(1e-2, static_cast<double>(us.front()))));
  const double hi = std::max(lo + 1, std::ceil(std::log10(std::max(1e-2, static_cast<double>(us.back())) * 1.0001)));
  std::vector<double> edges, counts;
  for (int i = 0; i <= static_cast<int>(12 * (hi - lo)); ++i) edges.push_back(std::pow(10.0, lo + i / 12.0));
  counts.resize(edges.size() - 1);
  for (const float v : us) {
    const auto above = std::upper_bound(edges.begin(), edges.end(), static_cast<double>(v));
    const auto bin =
        std::clamp<std::ptrdiff_t>(above - edges.begin() - 1, 0, static_cast<std::ptrdiff_t>(counts.size()) - 1);
    ++counts[static_cast<std::size_t>(bin)];
  }
  begin_table("timing", {say("ticks"), say("median"), "99 %", three_nines(), say("worst")},
              say("timing_caption", number(period, 0)));
  put("<tr><td class=\"text\">{}</td><td>{} µs</td><td>{} µs</td><td>{} µs</td><td>{} µs</td></tr>", us.size(),
      number(quantile(0.5)), number(quantile(0.99)), number(quantile(0.999)), number(us.back()));
  end_table();
  put("<div class=\"scroll\">{}</div>\n",
      histogram(edges, counts, "µs",
                say("histogram_alt", us.size(), number(quantile(0.5)), number(quantile(0.99)), number(us.back())),
                number_text()));
}

void Page::sound_times() {
  const auto heard = frames_of(session_, "sound");
  // Without sound, or if the sound was written to a file, there is no latency.
  if (!heard || heard->column("latency_s").empty()) return;
  begin_table("timing", {"", say("median"), "99 %", say("worst")}, say("sound_caption"));
  frame_row(*heard, "hand_to_sound", "latency_s", 1e3, "ms");
  end_table();
}

void Page::headset() {
  const auto shown = frames_of(session_, "headset");
  if (!shown) return;
  begin_section("headset", "headset");
  put("<p>{}</p>\n",
      say("headset_frames", shown->count(), number(shown->sum("drawn"), 0), number(shown->sum("missed"), 0)));
  begin_table("headset", {"", say("median"), "99 %", say("worst")}, say("headset_caption"));
  frame_row(*shown, "pose_to_submit", "pose_to_submit_s", 1e3, "ms");
  frame_row(*shown, "frame_margin", "margin_s", 1e3, "ms", true);
  frame_row(*shown, "head_error", "position_error_m", 1e3, "mm");
  frame_row(*shown, "head_angle_error", "angle_error_rad", 1 / kDegree, "°");
  end_table();
  end_section();
}

void Page::picture() {
  const auto shown = frames_of(session_, "picture");
  if (!shown) return;
  const std::vector<double> steps = shown->column("quality_step");
  begin_section("picture", "picture");
  put("<p>{}</p>\n", say("picture_frames", shown->count(), number(100 * shown->mean("redrawn"), 0),
                         steps.empty() ? 1 : static_cast<int>(steps.front()) + 1,
                         steps.empty() ? 1 : static_cast<int>(steps.back()) + 1));
  begin_table("picture", {"", say("median"), "99 %", say("worst")}, say("picture_caption"));
  frame_row(*shown, "frame_period", "period_s", 1e3, "ms");
  frame_row(*shown, "frame_record", "record_s", 1e3, "ms");
  frame_row(*shown, "frame_gpu", "gpu_s", 1e3, "ms");
  frame_row(*shown, "motion_to_photon", "motion_to_photon_s", 1e3, "ms");
  end_table();
  end_section();
}

void Page::events() {
  const auto& all = session_.events();
  if (all.empty()) return;
  begin_section("events", "events", Length::kLong);
  begin_table("events", {say("when"), say("what")}, "", 1);
  for (std::size_t i = 0; i < std::min(all.size(), kMaxEvents); ++i) {
    put("<tr><th scope=\"row\">{}</th><td class=\"text\">{}: {}</td></tr>\n", number(to_seconds(all[i].t), 2),
        say(fmt::format("event.{}", name_of(all[i].kind))), escaped(event_text(all[i])));
  }
  end_table();
  if (all.size() > kMaxEvents) put("<p class=\"soft\">{}</p>\n", say("more_events", all.size() - kMaxEvents));
  end_section();
}

}  // namespace typodont::session
