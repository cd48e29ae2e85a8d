#include "engine/session/page/page.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <utility>

#include "engine/base/json.h"
#include "engine/contract/safety_event.h"
#include "session_files.h"

namespace typodont::session {

std::string page_head(Language language, const std::string& title) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
      "'unsafe-inline'; "
      "script-src 'unsafe-inline'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n<style>{}</style>\n"
      "</head>\n<body>\n",
      tag_of(language), escaped(title), kStyle);
}
Page::Page(const SessionReader& session, const ReportOptions& options)
    : Words{options.language},
      session_(session),
      options_(options),
      course_(course_of(session)),
      input_(options.input ? *options.input : score_input(session, course_.hand, course_.removed_total)),
      score_(options.score ? *options.score : score_of(session, input_)) {
  scene_name_ = scene_name_of(session);
  if (!session.header().scene_json.empty()) {
    const Json scene = Json::parse(session.header().scene_json, session.file().string() + ": scene");
    if (const auto task = scene.find("task")) task_ = read_task(*task);
    tooth_ = tooth_sides(scene);
  }
}

std::string Page::html() {
  out_ = page_head(language, title());
  put("<a class=\"skip\" href=\"#result\">{}</a>\n", say("skip"));
  head();
  put("<main>\n<div id=\"report\">\n");
  warnings();
  summary();
  task();
  defects();
  remarks();
  result_views();
  pictures();
  items();
  implant();
  probing();
  comparison();
  volumes();
  over_time();
  events();
  put("</div>\n");
  technical_page();
  put("</main>\n<footer><p>{}</p></footer>\n</body>\n</html>\n",
      say("made_by", escaped(session_.header().program_version)));
  return std::move(out_);
}

void Page::begin_section(std::string_view id, std::string_view key, Length length) {
  put("<section id=\"{0}\"{1} aria-labelledby=\"h-{0}\">\n<h2 id=\"h-{0}\">{2}</h2>\n", id,
      length == Length::kLong ? " class=\"long\"" : "", say(key));
}

void Page::begin_table(std::string_view id, const std::vector<std::string>& heads, const std::string& caption,
                       std::size_t left_aligned) {
  put("<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-labelledby=\"h-{}\"><table>", id);
  if (!caption.empty()) put("<caption>{}</caption>", caption);
  put("<thead><tr>");
  for (std::size_t i = 0; i < heads.size(); ++i)
    put("<th scope=\"col\"{}>{}</th>", i < left_aligned ? "" : " class=\"text\"", heads[i]);
  put("</tr></thead>\n<tbody>\n");
}

std::string Page::tissue_text(std::size_t i) const {
  return say(fmt::format("tissue.{}", name_of(static_cast<Tissue>(i))));
}

std::string Page::title() const {
  if (task_ && !task_->title.empty()) return fmt::format("{}: {}", say("title"), task_->title.in(language));
  return scene_name_.empty() ? say("title") : fmt::format("{}: {}", say("title"), scene_name_);
}

std::string Page::duration_text() const {
  const double s = duration();
  if (s < 60) return fmt::format("{} s", number(s, 1));
  return fmt::format("{}:{:02d} min", static_cast<int>(s) / 60, static_cast<int>(s) % 60);
}

double Page::healthy_removed() const {
  const std::array<ScoreRule, 1> rule = {ScoreRule{"healthy_removed_mm3", 0, 1, 0, Best::kAtMost, ""}};
  const Score s = session::score(input_, rule);
  return s.items.empty() ? 0 : s.items.front().value;
}

void Page::gauge(double fraction, bool missed, double mark) {
  put("<div class=\"gauge{}\" aria-hidden=\"true\"><i style=\"width:{:.1f}%\"></i>", missed ? " missed" : "",
      100 * std::clamp(fraction, 0.0, 1.0));
  if (mark >= 0) put("<b style=\"left:{:.1f}%\"></b>", 100 * std::clamp(mark, 0.0, 1.0));
  put("</div>");
}

void Page::technical_page() {
  put("<div id=\"technical\" role=\"region\" aria-labelledby=\"h-technical\">\n<h2 id=\"h-technical\">{}</h2>\n"
      "<p class=\"back\"><a href=\"#result\">{}</a></p>\n",
      say("technical"), say("back_to_result"));
  faults();
  timing();
  headset();
  picture();
  details();
  put("</div>\n");
}

std::string Page::date_once_with_zone(const std::string& iso) {
  const auto local = local_time(iso);
  if (!local || std::exchange(zone_stated_, true)) return date(iso);
  return fmt::format("{} ({})", date(iso), local->zone);
}

std::string Page::fault_times(const Course::FaultCount& fault) const {
  constexpr double kShortest = 1e-3;  // s, because a shorter time would be shown as 0 s
  const double s = static_cast<double>(fault.ticks) / session_.header().servo_rate;
  const std::string time = quantity(std::max(s, kShortest), "s");
  return fault.times == 1 ? say("fault_once", time) : say("fault_times", fault.times, time);
}

void Page::head() {
  const SessionHeader& h = session_.header();
  put("<header>\n<h1>{}</h1>\n<p class=\"where\">", escaped(title()));
  std::vector<std::string> parts;
  if (!h.trainee.empty()) parts.push_back(escaped(h.trainee));
  if (!h.date.empty())
    parts.push_back(fmt::format("<time datetime=\"{}\">{}</time>", escaped(h.date), date_once_with_zone(h.date)));
  parts.push_back(duration_text());
  put("{}</p>\n</header>\n<nav aria-label=\"{}\"><ul>", fmt::join(parts, " · "), say("contents"));
  const auto link = [&](const char* id, const char* key) { put("<li><a href=\"#{}\">{}</a></li>", id, say(key)); };
  link("result", "result");
  if (task_) link("task", "task");
  if (!options_.defects.empty()) link("strokes", "strokes");
  if (!options_.remarks.empty()) link("remarks", "remarks");
  if (options_.result) link("form", "form");
  if (!all_pictures().empty()) link("pictures", "pictures");
  link("items", "items");
  if (compares()) link("comparison", "comparison");
  link("volumes", "volumes");
  if (course_.count > 0) link("course", "course");
  if (!session_.events().empty()) link("events", "events");
  link("technical", "technical");
  put("</ul></nav>\n");
}

void Page::warnings() {
  std::vector<std::string> texts;
  if (session_.truncated()) texts.push_back(say("warn.truncated"));
  if (session_.lost().any()) {
    const Lost& l = session_.lost();
    texts.push_back(say("warn.lost", l.ticks_ring + l.ticks_disk, l.cuts_ring + l.cuts_disk, l.pictures_disk,
                        l.other_ring + l.other_disk));
  }
  if (!session_.gaps().empty()) texts.push_back(say("warn.gaps", in_words(session_.gaps())));
  if (options_.verification.state == Verification::State::kDiffers)
    texts.push_back(say("warn.differs", escaped(options_.verification.what)));
  if (const Verification& v = options_.verification; v.state == Verification::State::kOtherLaw)
    texts.push_back(say("warn.other_law", escaped(session_.header().program_version), number(v.force_rms, 3),
                        number(v.force_max, 3), number(v.removed * 1e9, 3), number(v.removed_before * 1e9, 3)));
  if (!options_.not_measured.empty()) texts.push_back(say("warn.not_measured", escaped(options_.not_measured)));
  if (course_.count == 0) texts.push_back(say("warn.no_ticks"));
  if (texts.empty()) return;
  put("<div class=\"warn\" role=\"note\" aria-label=\"{}\">", say("attention"));
  for (const auto& t : texts) put("<p>{}</p>", t);
  put("</div>\n");
}

void Page::summary() {
  begin_section("result", "result");
  put("<div class=\"top\">\n<div>");
  if (score_.counts()) {
    const bool missed = !score_.passed();
    put("<p class=\"big{}\">{}<small> / {}</small></p>", missed ? " missed" : "",
        number(printed_points(score_.points), 1), number(score_.full, 0));
    gauge(score_.points / score_.full, missed, score_.pass.points / score_.full);
    put("<p class=\"verdict\">{}</p><p class=\"soft\">{}</p>", marked(say(missed ? "not_passed" : "passed"), missed),
        say("pass_mark", number(score_.pass.points, 0), escaped(text(score_.pass.source, language))));
    for (const ScoreItem& item : score_.items)
      if (item.critical) put("<p>{}</p>", marked(say("critical_error", name_of_item(item.name)), true));
  }
  put("</div>\n<dl class=\"key\">");
  const auto fact = [&](const std::string& name, const std::string& value) {
    put("<div><dt>{}</dt><dd>{}</dd></div>", name, value);
  };
  const auto caries = static_cast<std::size_t>(Tissue::kCaries);
  if (input_.before[caries] > 0) {
    fact(say("residual_caries"), fmt::format("{} ({}\u00a0%)", quantity(input_.after[caries] * 1e9, "mm³"),
                                             number(100 * input_.after[caries] / input_.before[caries], 1)));
  }
  fact(say("score.healthy_removed_mm3"), quantity(healthy_removed(), "mm³"));
  fact(say("duration"), duration_text());
  if (course_.count > 0) {
    fact(say("score.force_max_N"), quantity(course_.hand.force_max, "N"));
    fact(say("score.force_mean_N"), quantity(course_.hand.force_mean, "N"));
  }
  if (course_.all_faults.ticks > 0) {
    put("<div><dt>{}</dt><dd>{}</dd>", say("faults"), fault_times(course_.all_faults));
    for (std::size_t i = 0; i < course_.faults.size(); ++i)
      if (fault_names()[i].fault != Fault::kHeld && course_.faults[i].ticks > 0)
        put("<dd class=\"kind\">{}: {}</dd>", say("fault." + fault_names()[i].name), fault_times(course_.faults[i]));
    put("</div>");
  }
  put("</dl>\n</div>\n");
  end_section();
}

void Page::task() {
  if (!task_) return;
  begin_section("task", "task");
  put("<p>{}</p>\n", escaped(task_->goal.in(language)));
  if (!task_->steps.empty()) {
    put("<ol class=\"steps\">");
    for (const TaskText& step : task_->steps) put("<li>{}</li>", escaped(step.in(language)));
    put("</ol>\n");
  }
  end_section();
}

void Page::details() {
  const SessionHeader& h = session_.header();
  begin_section("details", "details", Length::kLong);
  put("<dl class=\"list\">");
  const auto entry = [&](const char* key, const std::string& value) {
    if (!value.empty()) put("<dt>{}</dt><dd>{}</dd>", say(key), value);
  };
  entry("scene", escaped(scene_name_));
  // Shows file names without folders, because folders can contain names of users and patients.
  const auto file_name = [](const std::string& path) {
    return escaped(std::filesystem::path(path).filename().string());
  };
  entry("hand", file_name(h.hand));
  std::vector<std::string> texts;
  for (const auto& tool : h.tools)
    texts.push_back(fmt::format("{} ({})", escaped(tool_text(tool, language)), escaped(tool)));
  entry("tools", fmt::format("{}", fmt::join(texts, ", ")));
  entry("servo_rate", fmt::format("{} Hz", number(h.servo_rate, 0)));
  if (h.voxel > 0) entry("voxel", fmt::format("{} mm", number(h.voxel * 1e3, 3)));
  entry("program", "Typodont " + escaped(h.program_version));
  entry("compiler", escaped(h.compiler));
  texts.clear();
  for (const auto& [name, seed] : h.seeds) texts.push_back(fmt::format("{} {}", escaped(name), seed));
  entry("seeds", fmt::format("{}", fmt::join(texts, ", ")));
  texts.clear();
  for (const auto& f : h.files) texts.push_back(fmt::format("{} <code>{}</code>", file_name(f.path), escaped(f.hash)));
  entry("files", fmt::format("{}", fmt::join(texts, "<br>")));
  using State = Verification::State;
  if (options_.verification.state == State::kIdentical) entry("verification", say("verification.identical"));
  if (options_.verification.state == State::kNotChecked) entry("verification", say("verification.none"));
  entry("session_file", escaped(session_.file().filename().string()));
  put("</dl>\n");
  end_section();
}

}  // namespace typodont::session
