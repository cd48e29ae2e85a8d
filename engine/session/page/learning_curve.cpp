#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <tuple>

#include "engine/session/page/page.h"
#include "engine/session/page/plot.h"

namespace typodont::session {

namespace {

/// Title of the task, or else name of the scene.
std::string heading_of(const SessionSummary& session, const Words& words, Language language) {
  if (!session.title.empty()) return session.title.in(language);
  return session.scene.empty() ? words.say("scene") : session.scene;
}

}  // namespace

std::string learning_curve_html(std::span<const SessionSummary> sessions, Language language) {
  const Words words{language};
  std::string out = page_head(language, words.say("title.curve"));
  const auto put = [&]<class... Args>(fmt::format_string<Args...> format, Args&&... args) {
    out += fmt::format(format, std::forward<Args>(args)...);
  };
  std::vector<SessionSummary> all(sessions.begin(), sessions.end());
  std::stable_sort(all.begin(), all.end(), [](const SessionSummary& a, const SessionSummary& b) {
    return std::tie(a.date, a.file) < std::tie(b.date, b.file);
  });
  // Only sessions of the same scene are compared.
  std::vector<std::string> scenes;
  for (const SessionSummary& s : all) {
    if (std::find(scenes.begin(), scenes.end(), s.scene) == scenes.end()) scenes.push_back(s.scene);
  }
  // The time zone of all dates below; in summer and winter it differs.
  std::set<std::string> zones;
  for (const SessionSummary& s : all)
    if (const auto local = local_time(s.date)) zones.insert(local->zone);
  put("<header><h1>{}</h1><p class=\"where\">{}</p></header>\n<main>\n", words.say("title.curve"),
      words.say("sessions_count", all.size()) +
          (zones.empty() ? "" : " · " + words.say("times_in", fmt::format("{}", fmt::join(zones, ", ")))));
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    std::vector<const SessionSummary*> mine;
    for (const SessionSummary& s : all) {
      if (s.scene == scenes[k]) mine.push_back(&s);
    }
    put("<section class=\"long\" aria-labelledby=\"scene-{0}\"><h2 id=\"scene-{0}\">{1}</h2>\n<div class=\"curves\">\n",
        k, escaped(heading_of(*mine.back(), words, language)));
    const auto curve = [&](const std::string& title, const std::string& unit, std::optional<double> target,
                           const std::function<std::optional<double>(const SessionSummary&)>& value) {
      std::vector<double> values;
      for (const SessionSummary* s : mine) values.push_back(value(*s).value_or(std::nan("")));
      const auto first = std::find_if(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
      const auto last = std::find_if(values.rbegin(), values.rend(), [](double v) { return !std::isnan(v); });
      if (first == values.end()) return;
      put("<figure>{}<figcaption>{}{}</figcaption></figure>\n",
          session_plot(values, target,
                       words.say("curve_alt", title, words.quantity(*first, unit), words.quantity(*last, unit)),
                       words.number_text()),
          title, unit.empty() ? std::string() : fmt::format(" ({})", unit));
    };
    // The score over time, with a line at the pass mark.
    const Score& newest = mine.back()->score;
    curve(words.say("score"), "", newest.counts() ? std::optional(newest.pass.points) : std::nullopt,
          [](const SessionSummary& s) -> std::optional<double> {
            if (!s.score.counts()) return std::nullopt;
            return printed_points(s.score.points);
          });
    for (const ScoreItem& item : mine.back()->score.items) {
      if (item.weight <= 0) continue;
      curve(words.name_of_item(item.name), item.unit, item.target,
            [&](const SessionSummary& s) -> std::optional<double> {
              for (const ScoreItem& other : s.score.items) {
                if (other.name == item.name) return other.value;
              }
              return std::nullopt;
            });
    }
    put("</div>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" "
        "aria-labelledby=\"scene-{}\"><table><thead><tr><th "
        "scope=\"col\">{}</th><th scope=\"col\">{}</th><th scope=\"col\">{}</th>",
        k, words.say("session_file"), words.say("date"), words.say("score"));
    for (const ScoreItem& item : mine.back()->score.items) {
      if (item.weight > 0) put("<th scope=\"col\">{}</th>", words.name_of_item(item.name));
    }
    put("</tr></thead>\n<tbody>\n");
    for (const SessionSummary* s : mine) {
      put("<tr><th scope=\"row\">{}{}</th><td>{}</td><td>{}</td>", escaped(s->file),
          s->truncated ? " (" + words.say("cut_off") + ")" : std::string(), words.date(s->date), words.total(s->score));
      for (const ScoreItem& item : mine.back()->score.items) {
        if (item.weight <= 0) continue;
        const auto& items = s->score.items;
        const auto it =
            std::find_if(items.begin(), items.end(), [&](const ScoreItem& i) { return i.name == item.name; });
        put("<td>{}</td>", it == items.end() ? std::string() : words.quantity(it->value, it->unit));
      }
      put("</tr>\n");
    }
    put("</tbody></table></div>\n</section>\n");
  }
  put("</main>\n<footer><p>{}</p></footer>\n</body>\n</html>\n", words.say("made_by", TYPODONT_VERSION));
  return out;
}

}  // namespace typodont::session
