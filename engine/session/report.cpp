#include "engine/session/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <functional>
#include <numeric>
#include <tuple>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/contract/safety_event.h"
#include "engine/session/format/columns.h"
#include "engine/session/page/model_colors.h"
#include "engine/session/page/plot.h"
#include "engine/session/page/section.h"
#include "engine/session/page/style.h"
#include "engine/session/page/viewer.h"
#include "engine/session/page/words.h"
#include "engine/session/task.h"

namespace typodont::session {

namespace {

constexpr std::uint64_t kPiece = 8192;  // ticks read at a time: memory does not grow with the session
constexpr std::size_t kBins = 480;      // of the plots over time
constexpr std::size_t kTableBins = 12;  // of their tables
constexpr Nanos kSpeedOver = 20'000'000;  // ns, over which the hand's speed is taken: no noise of the encoders
constexpr std::size_t kMostEvents = 200;

/// Everything the page needs to know of the ticks, in one pass.
struct Course {
  double t0 = 0, t1 = 1;  // s
  std::uint64_t count = 0;
  Series force, speed, spindle, depth, removed;  // N, mm/s, krpm, mm, mm³
  double most_spindle = 0;                       // krpm
  std::vector<std::array<std::uint32_t, kTissueCount>> touched;  // ticks per bin and tissue in contact
  struct FaultCount {
    std::uint64_t ticks = 0;
    double first = 0;
  };
  std::vector<FaultCount> faults;  // parallel to fault_names()
  std::vector<float> cpu_us;
  PerTissue removed_total{};  // m³
  HandMeasures hand;
};

struct Accumulator {
  std::vector<double> least, sum, greatest;
  std::vector<std::uint64_t> count;
  explicit Accumulator(std::size_t n) : least(n, 1e300), sum(n, 0), greatest(n, -1e300), count(n, 0) {}
  void add(std::size_t bin, double v) {
    if (!std::isfinite(v)) return;
    least[bin] = std::min(least[bin], v);
    greatest[bin] = std::max(greatest[bin], v);
    sum[bin] += v;
    ++count[bin];
  }
  Series series() const {
    Series s;
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const bool some = count[i] > 0;
      s.least.push_back(some ? least[i] : std::nan(""));
      s.mean.push_back(some ? sum[i] / static_cast<double>(count[i]) : std::nan(""));
      s.greatest.push_back(some ? greatest[i] : std::nan(""));
    }
    return s;
  }
};

Course course_of(const SessionReader& session) {
  Course c;
  c.count = session.tick_count();
  c.faults.resize(fault_names().size());
  if (c.count > 0) {
    c.t0 = to_seconds(session.ticks(0, 1).front().t);
    c.t1 = to_seconds(session.ticks(c.count - 1, 1).front().t);
  }
  if (!(c.t1 > c.t0)) c.t1 = c.t0 + 1;
  const std::size_t bins = std::clamp<std::size_t>(c.count, 1, kBins);
  Accumulator force(bins), speed(bins), spindle(bins), depth(bins), removed(bins);
  std::optional<ServoTick> moved_from;
  c.touched.resize(bins);
  HandMeter meter(session.header().servo_rate);
  for (std::uint64_t first = 0; first < c.count; first += kPiece) {
    const auto ticks = session.ticks(first, kPiece);
    meter.add(ticks);
    for (const ServoTick& tick : ticks) {
      const double t = to_seconds(tick.t);
      const double place = (t - c.t0) / (c.t1 - c.t0) * static_cast<double>(bins);
      const auto bin = static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(bins - 1)));
      force.add(bin, glm::length(tick.f_T_W));
      depth.add(bin, tick.depth * 1e3);
      spindle.add(bin, std::abs(tick.spindle) * 60 / (2 * kPi) / 1e3);
      c.most_spindle = std::max(c.most_spindle, std::abs(tick.spindle) * 60 / (2 * kPi) / 1e3);
      if (!moved_from || tick.t - moved_from->t >= kSpeedOver) {
        if (moved_from) speed.add(bin, glm::length(tick.X_WT.p - moved_from->X_WT.p) * 1e3 / to_seconds(tick.t - moved_from->t));
        moved_from = tick;
      }
      removed.add(bin, std::accumulate(tick.removed.begin(), tick.removed.end(), 0.0) * 1e9);
      if (tick.depth > 0 || tick.contact_area > 0) ++c.touched[bin][static_cast<std::size_t>(tick.tissue)];
      for (std::size_t i = 0; i < c.faults.size(); ++i) {
        if (!(tick.faults & bits(fault_names()[i].fault))) continue;
        if (c.faults[i].ticks++ == 0) c.faults[i].first = t;
      }
      if (tick.cpu_time > 0) c.cpu_us.push_back(static_cast<float>(static_cast<double>(tick.cpu_time) / 1e3));
      c.removed_total = tick.removed;
    }
  }
  c.force = force.series();
  c.speed = speed.series();
  c.spindle = spindle.series();
  c.depth = depth.series();
  c.removed = removed.series();
  c.hand = meter.result();
  return c;
}

ScoreInput input_of(const SessionReader& session, const Course& course) {
  ScoreInput in;
  in.before = session.header().volumes_before;
  in.hand = course.hand;
  const auto& result = session.result();
  if (result && result->has_volumes) {
    in.after = result->volumes_after;
  } else {
    for (std::size_t i = 0; i < kTissueCount; ++i) in.after[i] = std::max(0.0, in.before[i] - course.removed_total[i]);
  }
  if (result && result->has_ideal) in.ideal = result->volumes_ideal;
  if (result && result->min_pulp_distance >= 0) in.pulp_distance = result->min_pulp_distance;
  return in;
}

Score score_of(const SessionReader& session, const ScoreInput& input) {
  if (session.header().scene_json.empty()) return score(input, default_rules(input));
  return score(input, rules_of_scene(Json::parse(session.header().scene_json, session.file().string() + ": scene"), input));
}

std::string scene_name_of(const SessionReader& session) {
  if (session.header().scene_json.empty()) return "";
  const Json scene = Json::parse(session.header().scene_json, session.file().string() + ": scene");
  return scene.is_object() ? scene.string_or("name", "") : "";
}

std::string page_head(Language language, const std::string& title) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; "
      "script-src 'unsafe-inline'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n<style>{}</style>\n"
      "</head>\n<body>\n",
      tag_of(language), escaped(title), kStyle);
}

/// Writes one page; holds what every part of it needs.
class Page : private Words {
 public:
  Page(const SessionReader& session, const ReportOptions& options)
      : Words{options.language}, session_(session), options_(options), course_(course_of(session)),
        input_(options.input ? *options.input : input_of(session, course_)), score_(options.score ? *options.score : score_of(session, input_)) {
    scene_name_ = scene_name_of(session);
    if (!session.header().scene_json.empty()) {
      const Json scene = Json::parse(session.header().scene_json, session.file().string() + ": scene");
      if (const auto task = scene.find("task")) task_ = read_task(*task);
    }
  }

  std::string html() {
    out_ = page_head(language, title());
    put("<a class=\"skip\" href=\"#result\">{}</a>\n", say("skip"));
    head();
    put("<main>\n");
    warnings();
    summary();
    task();
    result_views();
    pictures();
    items();
    comparison();
    volumes();
    over_time();
    faults();
    timing();
    headset();
    picture();
    events();
    details();
    put("</main>\n<footer><p>{}</p></footer>\n</body>\n</html>\n",
        say("made_by", escaped(session_.header().program_version)));
    return std::move(out_);
  }

 private:
  template <class... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
  }
  std::string tissue_text(std::size_t i) const {
    return say(fmt::format("tissue.{}", name_of(static_cast<Tissue>(i))));
  }
  std::string title() const {
    if (task_ && !task_->title.empty()) return fmt::format("{}: {}", say("title"), task_->title.in(language));
    return scene_name_.empty() ? say("title") : fmt::format("{}: {}", say("title"), scene_name_);
  }
  double duration() const { return course_.count > 0 ? course_.t1 - course_.t0 : 0; }
  std::string duration_text() const {
    const double s = duration();
    if (s < 60) return fmt::format("{} s", number(s, 1));
    return fmt::format("{}:{:02d} min", static_cast<int>(s) / 60, static_cast<int>(s) % 60);
  }

  void head() {
    const SessionHeader& h = session_.header();
    put("<header>\n<h1>{}</h1>\n<p class=\"where\">", escaped(title()));
    std::vector<std::string> parts;
    if (!h.trainee.empty()) parts.push_back(escaped(h.trainee));
    if (!h.date.empty()) parts.push_back(fmt::format("<time datetime=\"{0}\">{1}</time>", escaped(h.date), date(h.date)));
    parts.push_back(duration_text());
    put("{}</p>\n</header>\n<nav aria-label=\"{}\"><ul>", fmt::join(parts, " · "), say("contents"));
    const auto link = [&](const char* id, const char* key) { put("<li><a href=\"#{}\">{}</a></li>", id, say(key)); };
    link("result", "result");
    if (task_) link("task", "task");
    if (options_.result) link("form", "form");
    if (!all_pictures().empty()) link("pictures", "pictures");
    link("items", "items");
    if (compares()) link("comparison", "comparison");
    link("volumes", "volumes");
    if (course_.count > 0) {
      link("course", "course");
      link("faults", "faults");
    }
    if (!course_.cpu_us.empty() || session_.loop()) link("timing", "timing");
    if (headset_frames()) link("headset", "headset");
    if (picture_frames()) link("picture", "picture");
    if (!session_.events().empty()) link("events", "events");
    link("details", "details");
    put("</ul></nav>\n");
  }

  void warnings() {
    std::vector<std::string> texts;
    if (session_.truncated()) texts.push_back(say("warn.truncated"));
    if (session_.lost().any()) {
      const Lost& l = session_.lost();
      texts.push_back(say("warn.lost", l.ticks_ring + l.ticks_disk, l.cuts_ring + l.cuts_disk));
    }
    if (course_.count == 0) texts.push_back(say("warn.no_ticks"));
    if (texts.empty()) return;
    put("<div class=\"warn\" role=\"note\" aria-label=\"{}\">", say("attention"));
    for (const auto& t : texts) put("<p>{}</p>", t);
    put("</div>\n");
  }

  void gauge(double share) {
    put("<div class=\"gauge\" aria-hidden=\"true\"><i style=\"width:{:.1f}%\"></i></div>",
        100 * std::clamp(share, 0.0, 1.0));
  }

  void summary() {
    put("<section id=\"result\" aria-labelledby=\"h-result\">\n<h2 id=\"h-result\">{}</h2>\n<div class=\"top\">\n<div>", say("result"));
    if (score_.full > 0) {
      const double share = score_.points / score_.full;
      put("<p class=\"big\" style=\"margin:0\">{}<small> %</small></p>", number(100 * share, 0));
      gauge(share);
      put("<p class=\"soft\">{}</p>", say("points_of", number(score_.points, 1), number(score_.full, 0)));
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
      fact(say("faults"), fmt::format("{}", course_.hand.faults));
    }
    put("</dl>\n</div>\n</section>\n");
  }

  double healthy_removed() const {
    const std::array<ScoreRule, 1> rule = {ScoreRule{"healthy_removed_mm3", 0, 1, 0, Best::kAtMost, ""}};
    const Score s = session::score(input_, rule);
    return s.items.empty() ? 0 : s.items.front().value;
  }

  std::vector<SessionPicture> all_pictures() const {
    std::vector<SessionPicture> all;
    if (session_.result()) all = session_.result()->pictures;
    for (const SessionPicture& p : options_.more_pictures) {
      std::erase_if(all, [&](const SessionPicture& q) { return q.name == p.name; });
      all.push_back(p);
    }
    std::stable_sort(all.begin(), all.end(), [](const SessionPicture& a, const SessionPicture& b) {
      return std::pair(rank_of(a), a.name) < std::pair(rank_of(b), b.name);
    });
    return all;
  }
  static int rank_of(const SessionPicture& p) {
    return p.name.starts_with("before") ? 0 : p.name.starts_with("during") ? 1 : p.name.starts_with("after") ? 2 : 3;
  }

  void task() {
    if (!task_) return;
    put("<section id=\"task\" aria-labelledby=\"h-task\">\n<h2 id=\"h-task\">{}</h2>\n<p>{}</p>\n", say("task"),
        escaped(task_->goal.in(language)));
    if (!task_->steps.empty()) {
      put("<ol class=\"steps\">");
      for (const TaskText& step : task_->steps) put("<li>{}</li>", escaped(step.in(language)));
      put("</ol>\n");
    }
    put("</section>\n");
  }

  bool has_ideal() const { return options_.preparation && !options_.preparation->ideal.distance.empty(); }

  /// The views that are drawn and that the turnable one starts from.
  struct Views {
    ModelView above, front, side, angled;
    dvec3 to_right{1, 0, 0};
  };
  Views views() const {
    const dvec3 axis = options_.preparation ? options_.preparation->axis_W : dvec3(0, 0, 1);
    const dvec3 other = std::abs(axis.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 0, 1);
    const dvec3 right = glm::normalize(other - glm::dot(other, axis) * axis), away = glm::cross(axis, right);
    return {{-axis, away}, {away, axis}, {-right, axis}, {glm::normalize(-0.75 * axis + 0.6 * away - 0.3 * right), axis}, right};
  }

  void result_views() {
    if (!options_.result) return;
    const ResultModel& model = *options_.result;
    const Views at = views();
    put("<section id=\"form\" class=\"long\" aria-labelledby=\"h-form\">\n<h2 id=\"h-form\">{}</h2>\n", say("form"));
    if (has_ideal()) {
      put("<p class=\"soft\">{}</p>\n", say("form_note"));
      worst_places();
    }
    put("<div class=\"pictures\">\n");
    const auto picture = [&](const ModelView& view, bool difference, const std::string& caption) {
      put("<figure><img alt=\"{}\" src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
          escaped(say("picture.alt", caption)), base64(draw_model(model, view, {420, 320}, difference)), escaped(caption));
    };
    picture(at.above, false, say("view.above"));
    picture(at.angled, false, say("view.angled"));
    if (has_ideal()) {
      const auto map = [&](const char* key) { return fmt::format("{}: {}", say("difference"), say(key)); };
      picture(at.above, true, map("view.above"));
      picture(at.front, true, map("view.front"));
      picture(at.side, true, map("view.side"));
      picture(at.angled, true, map("view.angled"));
    }
    put("</div>\n");
    if (has_ideal()) color_bar();
    viewer(at);
    sections(at);
    put("</section>\n");
  }

  void worst_places() {
    if (!input_.cavity) return;
    const CavityMeasures& c = *input_.cavity;
    const auto say_place = [&](const char* key, const Place& place) {
      if (!(place.depth > 0)) return;
      put("<p>{}</p>\n", say(key, quantity(place.depth * 1e3, "mm"), number(place.p_W.x * 1e3, 1), number(place.p_W.y * 1e3, 1),
                            number(place.p_W.z * 1e3, 1)));
    };
    say_place("worst_over", c.over);
    say_place("worst_under", c.under);
  }

  void color_bar() {
    const auto css = [](std::size_t i) {
      const auto& c = kDifferenceColors[i];
      return fmt::format("rgb({},{},{})", c[0], c[1], c[2]);
    };
    const std::string full = number(kFullColor * 1e3, 1);
    put("<div class=\"colorbar\" role=\"img\" aria-label=\"{0}\"><i style=\"background:linear-gradient(90deg,{1},{2},{3})\"></i>"
        "<span>−{4} mm {5}</span><span>0</span><span>+{4} mm {6}</span></div>\n",
        escaped(say("colorbar_alt")), css(2), css(1), css(0), full, say("too_deep"), say("too_much"));
  }

  void viewer(const Views& at) {
    put("<h3>{}</h3>\n<noscript><p class=\"soft\">{}</p></noscript>\n<div id=\"viewer\" hidden>\n<div class=\"buttons\" role=\"group\" "
        "aria-label=\"{}\">",
        say("turn"), say("no_script"), say("show"));
    const auto mode = [&](const char* name, const char* key) {
      put("<button type=\"button\" data-mode=\"{}\" aria-pressed=\"false\">{}</button>", name, say(key));
    };
    mode("result", "form");
    if (has_ideal()) mode("difference", "difference");
    if (options_.ideal) mode("ideal", "ideal");
    put("</div>\n<div class=\"buttons\" role=\"group\" aria-label=\"{}\">", say("view"));
    for (const char* name : {"above", "front", "side", "angled"}) {
      put("<button type=\"button\" data-look=\"{}\">{}</button>", name, say(std::string("view.") + name));
    }
    put("<button type=\"button\" data-look=\"reset\">{}</button>\n<label>{} <input type=\"range\" name=\"cut\" min=\"5\" max=\"100\" "
        "value=\"100\"></label></div>\n<canvas tabindex=\"0\" role=\"img\" aria-label=\"{}\"></canvas>\n<p class=\"soft\">{}</p>\n"
        "<p aria-live=\"polite\" class=\"hush\"></p>\n</div>\n",
        say("reset"), say("cut_open"), escaped(say("viewer_alt")), say("viewer_keys"));
    put("<script type=\"application/json\" id=\"model-data\">{}</script>\n<script>{}</script>\n", model_data(at), kViewerScript);
  }

  /// Positions in 16 bits over the result's bounds, normals and deviations in 8.
  std::string model_data(const Views& at) const {
    std::vector<const ResultModel*> models{&*options_.result};
    if (options_.ideal) models.push_back(&*options_.ideal);
    glm::vec3 lo(1e9f), hi(-1e9f);
    for (const ResultModel* m : models) {
      for (const auto& v : m->vertices) lo = glm::min(lo, v.p_W), hi = glm::max(hi, v.p_W);
    }
    const glm::vec3 middle = 0.5f * (lo + hi), extent = hi - lo;
    const float largest = std::max({extent.x, extent.y, extent.z, 1e-6f}), step = largest / 2 / 32767;
    const auto raw = []<class T>(const std::vector<T>& values) {
      const auto* p = reinterpret_cast<const unsigned char*>(values.data());
      return base64(std::vector<unsigned char>(p, p + values.size() * sizeof(T)));
    };
    std::vector<std::string> meshes;
    for (const ResultModel* m : models) {
      std::vector<std::int16_t> position;
      std::vector<std::int8_t> normal, off;
      std::vector<std::uint8_t> tissue;
      for (const auto& v : m->vertices) {
        for (int k = 0; k < 3; ++k) {
          position.push_back(static_cast<std::int16_t>(std::lround((v.p_W[k] - middle[k]) / step)));
          normal.push_back(static_cast<std::int8_t>(std::lround(127 * std::clamp(v.n[k], -1.0f, 1.0f))));
        }
        tissue.push_back(static_cast<std::uint8_t>(v.tissue));
        off.push_back(static_cast<std::int8_t>(std::lround(127 * std::clamp(v.off / static_cast<float>(kFullColor), -1.0f, 1.0f))));
      }
      std::vector<std::uint32_t> index;
      for (const auto& t : m->triangles) index.insert(index.end(), t.begin(), t.end());
      meshes.push_back(fmt::format("{{\"position\":\"{}\",\"normal\":\"{}\",\"tissue\":\"{}\",\"off\":\"{}\",\"index\":\"{}\"}}",
                                   raw(position), raw(normal), raw(tissue), raw(off), raw(index)));
    }
    const auto vec = [](const dvec3& v) { return fmt::format("[{:.5f},{:.5f},{:.5f}]", v.x, v.y, v.z); };
    const auto view = [&](const ModelView& v) { return fmt::format("{{\"back\":{},\"up\":{}}}", vec(-v.look_W), vec(v.up_W)); };
    std::vector<std::string> tissues, difference;
    for (const auto& c : kTissueColors) tissues.push_back(fmt::format("[{},{},{}]", c[0], c[1], c[2]));
    for (const auto& c : kDifferenceColors) difference.push_back(fmt::format("[{},{},{}]", c[0], c[1], c[2]));
    // It turns about what was worked on.
    glm::vec3 focus(0);
    if (options_.preparation) {
      const Preparation& p = *options_.preparation;
      focus = (glm::vec3(p.frame.to_world(0.5 * dvec3(p.before.size))) - middle) / step;
    }
    return fmt::format("{{\"has_ideal\":{},\"focus\":{},\"extent\":{:.6g},\"step\":{:.6g},\"tissues\":[{}],\"difference\":[{}],\"view\":{{"
                       "\"above\":{},\"front\":{},\"side\":{},\"angled\":{},\"slice\":{}}},\"meshes\":[{}]}}",
                       has_ideal() ? "true" : "false", vec(dvec3(focus)), glm::length(extent), step, fmt::join(tissues, ","), fmt::join(difference, ","),
                       view(at.above), view(at.front), view(at.side), view(at.angled), vec(-at.front.look_W), fmt::join(meshes, ","));
  }

  void sections(const Views& at) {
    if (!options_.preparation) return;
    // Through the worst place where there is one, else through the middle of what was looked at.
    const Preparation& p = *options_.preparation;
    dvec3 through = p.frame.to_world(0.5 * dvec3(p.before.size));
    if (input_.cavity) {
      const Place &over = input_.cavity->over, &under = input_.cavity->under;
      const Place& worst = over.depth > under.depth ? over : under;
      if (worst.depth > 0) through = worst.p_W;
    }
    const std::string front = section_svg(p, through, at.to_right, say("section_alt"));
    const std::string side = section_svg(p, through, glm::cross(p.axis_W, at.to_right), say("section_alt"));
    if (front.empty() && side.empty()) return;
    put("<h3>{}</h3>\n<p class=\"soft\">{}</p>\n<div class=\"pictures\">\n", say("sections"), say("sections_note"));
    for (const std::string& svg : {front, side}) {
      if (!svg.empty()) put("<figure>{}</figure>\n", svg);
    }
    put("</div>\n<ul class=\"legend\" aria-hidden=\"true\"><li class=\"k-was\">{}</li><li class=\"k-is\">{}</li>", say("before"), say("form"));
    if (has_ideal()) put("<li class=\"k-ideal\">{}</li>", say("ideal"));
    put("</ul>\n");
  }

  bool compares() const { return !options_.earlier.empty() || options_.expert; }

  static const ScoreItem* item_of(const Score& score, const std::string& name) {
    const auto it = std::find_if(score.items.begin(), score.items.end(), [&](const ScoreItem& i) { return i.name == name; });
    return it == score.items.end() ? nullptr : &*it;
  }

  void comparison() {
    if (!compares()) return;
    struct Column {
      std::string title;
      const Score* score;
    };
    std::vector<Column> columns{{say("this_session"), &score_}};
    if (!options_.earlier.empty()) {
      const SessionSummary& last = options_.earlier.back();
      columns.push_back({say("last_session"), &last.score});
      const auto best = std::max_element(options_.earlier.begin(), options_.earlier.end(), [](const auto& a, const auto& b) {
        return a.score.points < b.score.points;
      });
      columns.push_back({say("best_session"), &best->score});
    }
    if (options_.expert) columns.push_back({say("expert"), &options_.expert->score});
    put("<section id=\"comparison\" class=\"long\" aria-labelledby=\"h-comparison\">\n<h2 id=\"h-comparison\">{}</h2>\n<div class=\"scroll\" "
        "tabindex=\"0\" role=\"region\" aria-labelledby=\"h-comparison\"><table>",
        say("comparison"));
    if (!options_.earlier.empty()) put("<caption>{}</caption>", say("earlier_count", options_.earlier.size()));
    put("<thead><tr><th scope=\"col\">{}</th>", say("item"));
    for (const Column& c : columns) put("<th scope=\"col\">{}</th>", c.title);
    put("</tr></thead>\n<tbody>\n");
    for (const ScoreItem& item : score_.items) {
      if (item.weight <= 0) continue;
      put("<tr><th scope=\"row\">{}</th>", name_of_item(item.name));
      for (const Column& c : columns) {
        const ScoreItem* other = item_of(*c.score, item.name);
        put("<td>{}</td>", other ? quantity(other->value, other->unit) : "–");
      }
      put("</tr>\n");
    }
    put("</tbody>\n<tfoot><tr><th scope=\"row\">{}</th>", say("score"));
    for (const Column& c : columns) put("<td>{} %</td>", number(c.score->full > 0 ? 100 * c.score->points / c.score->full : 0, 0));
    put("</tr></tfoot>\n</table></div>\n");
    if (!options_.earlier.empty()) {
      std::vector<double> values;
      for (const SessionSummary& s : options_.earlier) values.push_back(s.score.full > 0 ? 100 * s.score.points / s.score.full : 0);
      values.push_back(score_.full > 0 ? 100 * score_.points / score_.full : 0);
      put("<figure>{}<figcaption>{} (%)</figcaption></figure>\n",
          session_plot(values, 100.0, say("curve_alt", say("score"), quantity(values.front(), "%"), quantity(values.back(), "%")),
                       number_text()),
          say("score"));
    }
    put("</section>\n");
  }

  void pictures() {
    const auto all = all_pictures();
    if (all.empty()) return;
    put("<section id=\"pictures\" class=\"long\" aria-labelledby=\"h-pictures\">\n<h2 id=\"h-pictures\">{}</h2>\n"
        "<div class=\"pictures\">\n",
        say("pictures"));
    for (const SessionPicture& p : all) {
      const std::string key = "picture." + p.name.substr(0, p.name.find('_'));
      const std::string caption = !p.title.empty() ? p.title : has_text(key) ? say(key) : p.name;
      put("<figure><img alt=\"{}\" src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
          escaped(say("picture.alt", caption)), base64(p.png), escaped(caption));
    }
    put("</div>\n</section>\n");
  }

  void items() {
    put("<section id=\"items\" class=\"long\" aria-labelledby=\"h-items\">\n<h2 id=\"h-items\">{}</h2>\n<div class=\"scroll\" "
        "tabindex=\"0\" role=\"region\" aria-labelledby=\"h-items\">\n<table><caption>{} {}: {} %.</caption>\n<thead><tr>"
        "<th scope=\"col\">{}</th><th scope=\"col\">{}</th><th scope=\"col\">{}</th><th scope=\"col\">{}</th><th scope=\"col\">{}</th>"
        "<th scope=\"col\" class=\"text\">{}</th></tr></thead>\n<tbody>\n",
        say("items"), say("completion_note"), say("completion"), number(100 * score_.completion, 0), say("item"), say("value"),
        say("target"), say("tolerance"), say("points"), say("source"));
    // What counts first.
    std::vector<const ScoreItem*> order;
    for (const ScoreItem& item : score_.items) order.push_back(&item);
    std::stable_sort(order.begin(), order.end(), [](auto* a, auto* b) { return a->weight > b->weight; });
    for (const ScoreItem* item : order) {
      put("<tr><th scope=\"row\">{}</th><td>{}</td>", name_of_item(item->name),
          std::isnan(item->value) ? say("not_there") : quantity(item->value, item->unit));
      if (item->weight > 0) {
        put("<td>{}</td><td>{}</td><td>{} / {}", target(*item), quantity(item->tolerance, item->unit),
            number(item->points, 1), number(item->weight, 0));
        gauge(item->points / item->weight);
        // The sources of the default rules are in the catalogue, by their English text.
        put("</td><td class=\"text source\">{}</td></tr>\n", escaped(text(item->source, language)));
      } else {
        put("<td></td><td></td><td>{}</td><td class=\"text source\"></td></tr>\n", say("not_counted"));
      }
    }
    put("</tbody>\n<tfoot><tr><th scope=\"row\">{}</th><td></td><td></td><td></td><td>{} / {}</td><td></td></tr></tfoot>\n"
        "</table></div>\n</section>\n",
        say("score"), number(score_.points, 1), number(score_.full, 0));
  }

  void volumes() {
    put("<section id=\"volumes\" aria-labelledby=\"h-volumes\">\n<h2 id=\"h-volumes\">{}</h2>\n<div class=\"scroll\" tabindex=\"0\" "
        "role=\"region\" aria-labelledby=\"h-volumes\">\n<table><caption>{}</caption>\n<thead><tr><th scope=\"col\">{}</th>"
        "<th scope=\"col\">{}</th><th scope=\"col\">{}</th><th scope=\"col\">{}</th>",
        say("volumes"), say("volumes_caption"), say("tissue"), say("before"), say("removed"), say("after"));
    if (input_.ideal) put("<th scope=\"col\">{}</th>", say("ideal"));
    put("<th scope=\"col\">{}</th></tr></thead>\n<tbody>\n", say("share_removed"));
    double before_sum = 0, after_sum = 0, ideal_sum = 0;
    for (std::size_t i = 1; i < kTissueCount; ++i) {
      const double before = input_.before[i] * 1e9, after = input_.after[i] * 1e9;
      const double ideal = input_.ideal ? (*input_.ideal)[i] * 1e9 : 0;
      if (before <= 0 && after <= 0 && ideal <= 0) continue;
      before_sum += before;
      after_sum += after;
      ideal_sum += ideal;
      put("<tr{}><th scope=\"row\"><span class=\"swatch s-{}\" aria-hidden=\"true\"></span>{}</th><td>{}</td><td>{}</td><td>{}</td>",
          static_cast<Tissue>(i) == Tissue::kCaries ? " class=\"key\"" : "", name_of(static_cast<Tissue>(i)), tissue_text(i),
          number(before, 2), number(before - after, 2), number(after, 2));
      if (input_.ideal) put("<td>{}</td>", number(ideal, 2));
      if (before > 0) {
        put("<td>{} %</td></tr>\n", number(100 * (before - after) / before, 1));
      } else {
        put("<td></td></tr>\n");
      }
    }
    put("</tbody>\n<tfoot><tr><th scope=\"row\">Σ</th><td>{}</td><td>{}</td><td>{}</td>", number(before_sum, 2),
        number(before_sum - after_sum, 2), number(after_sum, 2));
    if (input_.ideal) put("<td>{}</td>", number(ideal_sum, 2));
    put("<td></td></tr></tfoot>\n</table></div>\n</section>\n");
  }

  std::vector<TimePlot::Mark> marks() const {
    std::vector<TimePlot::Mark> result;
    for (const SessionEvent& e : session_.events()) {
      if (result.size() == kMostEvents) break;
      const std::string kind(name_of(e.kind));
      result.push_back({to_seconds(e.t), fmt::format("{}: {}", say("event." + kind), e.text), kind});
    }
    for (std::size_t i = 0; i < course_.faults.size(); ++i) {
      if (course_.faults[i].ticks == 0) continue;
      result.push_back({course_.faults[i].first, say("fault." + fault_names()[i].name), "fault"});
    }
    return result;
  }

  void plot(const char* key, const char* css, const char* unit, const Series& s, int decimals, const char* note = nullptr) {
    double sum = 0, greatest = 0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < s.mean.size(); ++i) {
      if (std::isnan(s.mean[i])) continue;
      sum += s.mean[i];
      greatest = std::max(greatest, s.greatest[i]);
      ++n;
    }
    const double mean = n ? sum / static_cast<double>(n) : 0;
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
    // The plot as numbers, for those who cannot see it.
    put("\n<details><summary>{}</summary><table><caption>{} ({})</caption><thead><tr><th scope=\"col\">{}</th><th scope=\"col\">{}</th>"
        "<th scope=\"col\">{}</th></tr></thead><tbody>",
        say("as_table"), say(key), unit, say("from_to"), say("mean"), say("greatest"));
    const std::size_t bins = s.mean.size(), rows = std::min(bins, kTableBins);
    for (std::size_t r = 0; r < rows; ++r) {
      const std::size_t from = r * bins / rows, to = (r + 1) * bins / rows;
      double row_sum = 0, row_greatest = 0;
      std::size_t row_n = 0;
      for (std::size_t i = from; i < to; ++i) {
        if (std::isnan(s.mean[i])) continue;
        row_sum += s.mean[i];
        row_greatest = std::max(row_greatest, s.greatest[i]);
        ++row_n;
      }
      const auto t_of = [&](std::size_t bin) {
        return course_.t0 + (course_.t1 - course_.t0) * static_cast<double>(bin) / static_cast<double>(bins);
      };
      put("<tr><th scope=\"row\">{}–{}</th><td>{}</td><td>{}</td></tr>", number(t_of(from), 1), number(t_of(to), 1),
          row_n ? number(row_sum / static_cast<double>(row_n), decimals) : "–", row_n ? number(row_greatest, decimals) : "–");
    }
    put("</tbody></table></details>\n");
  }

  void over_time() {
    if (course_.count == 0) return;
    put("<section id=\"course\" class=\"long\" aria-labelledby=\"h-course\">\n<h2 id=\"h-course\">{}</h2>\n", say("course"));
    plot("force", "force", "N", course_.force, 2);
    touched();
    plot("speed", "speed", "mm/s", course_.speed, 1, "speed_note");
    if (course_.most_spindle > 0) plot("spindle", "spindle", "krpm", course_.spindle, 0);
    plot("depth", "depth", "mm", course_.depth, 3, "depth_note");
    plot("removed_course", "removed", "mm³", course_.removed, 2);
    put("</section>\n");
  }

  /// Under the force: which tissue answers.
  void touched() {
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
    std::vector<std::string> shares;
    for (std::size_t i = 1; i < kTissueCount; ++i) {
      if (total[i] > 0) {
        shares.push_back(fmt::format("{} {} %", tissue_text(i), number(100.0 * static_cast<double>(total[i]) / static_cast<double>(all), 0)));
      }
    }
    put("<h3>{}</h3>\n", say("touched"));
    put("<div class=\"scroll\">{}</div>\n",
        strip(css, fmt::format("{}: {}", say("touched"), fmt::join(shares, ", "))));
    put("<ul class=\"legend\" aria-hidden=\"true\">");
    std::size_t k = 0;
    for (std::size_t i = 1; i < kTissueCount; ++i) {
      if (total[i] > 0) put("<li><span class=\"swatch s-{}\"></span>{}</li>", name_of(static_cast<Tissue>(i)), shares[k++]);
    }
    put("</ul>\n");
  }

  void faults() {
    if (course_.count == 0) return;
    put("<section id=\"faults\" aria-labelledby=\"h-faults\">\n<h2 id=\"h-faults\">{}</h2>\n", say("faults"));
    if (course_.hand.faults == 0) {
      put("<p>{}</p>\n</section>\n", say("no_faults"));
      return;
    }
    put("<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-labelledby=\"h-faults\"><table><thead><tr><th scope=\"col\">{}</th><th scope=\"col\">{}</th><th scope=\"col\">{}</th></tr></thead>\n<tbody>\n",
        say("fault"), say("ticks"), say("first_at"));
    for (std::size_t i = 0; i < course_.faults.size(); ++i) {
      const auto& f = course_.faults[i];
      if (f.ticks == 0) continue;
      put("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td></tr>\n", say("fault." + fault_names()[i].name), f.ticks,
          number(f.first, 3));
    }
    put("</tbody></table></div>\n</section>\n");
  }

  void timing() {
    if (course_.cpu_us.empty() && !session_.loop()) return;
    put("<section id=\"timing\" aria-labelledby=\"h-timing\">\n<h2 id=\"h-timing\">{}</h2>\n", say("timing"));
    cpu_times();
    if (session_.loop()) {
      loop_times(*session_.loop());
      real_time(*session_.loop());
    }
    put("</section>\n");
  }

  std::string three_nines() const { return language == Language::kGerman ? "99,9 %" : "99.9 %"; }

  /// Median, 99 %, 99.9 % and worst of what a live loop counted.
  void loop_times(const LoopReport& loop) {
    const LoopTiming& t = loop.timing;
    const double share = 100 * static_cast<double>(t.misses) / static_cast<double>(std::max<std::uint64_t>(t.ticks, 1));
    put("<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-labelledby=\"h-timing\"><table><caption>{}</caption><thead><tr><th scope=\"col\"></th><th scope=\"col\">{}</th><th scope=\"col\">99 %</th>"
        "<th scope=\"col\">{}</th><th scope=\"col\">{}</th></tr></thead>\n<tbody>",
        say("loop_caption", t.ticks, t.misses, number(share, share > 0 && share < 0.01 ? 4 : 2),
            number(static_cast<double>(t.worst_index) * to_seconds(t.period), 2)),
        say("median"), three_nines(), say("worst"));
    const auto row = [&](const char* key, const DurationHistogram& h, Nanos worst) {
      // A quantile is the end of its bin, which may lie beyond the worst one in it.
      const auto us = [&](double q) { return number(std::min(h.quantile(q), static_cast<double>(worst)) / 1e3); };
      put("<tr><th scope=\"row\">{}</th><td>{} µs</td><td>{} µs</td><td>{} µs</td><td>{} µs</td></tr>\n", say(key), us(0.5),
          us(0.99), us(0.999), number(static_cast<double>(worst) / 1e3));
    };
    row("loop_work", t.work, t.worst_tick);
    row("loop_jitter", t.jitter, t.worst_jitter);
    put("</tbody></table></div>\n");
    int first = DurationHistogram::kBins, last = -1;
    for (int i = 0; i < DurationHistogram::kBins; ++i) {
      if (t.jitter.counts[static_cast<std::size_t>(i)] == 0) continue;
      first = std::min(first, i);
      last = i;
    }
    if (last < 0) return;
    // A whole decade at least, so that its axis has marks.
    first = std::max(0, std::min(first, last - 27));
    last = std::min(DurationHistogram::kBins - 1, std::max(last, first + 27));
    std::vector<double> edges{DurationHistogram::upper_edge(first) / 1e3 * std::exp2(-1.0 / DurationHistogram::kPerOctave)}, counts;
    for (int i = first; i <= last; ++i) {
      edges.push_back(DurationHistogram::upper_edge(i) / 1e3);
      counts.push_back(t.jitter.counts[static_cast<std::size_t>(i)]);
    }
    const auto us = [&](double q) {
      return number(std::min(t.jitter.quantile(q), static_cast<double>(t.worst_jitter)) / 1e3);
    };
    put("<div class=\"scroll\">{}</div>\n",
        histogram(edges, counts, "µs",
                  say("loop_jitter_alt", t.jitter.total(), us(0.5), us(0.99), number(static_cast<double>(t.worst_jitter) / 1e3)),
                  number_text()));
  }

  void real_time(const LoopReport& loop) {
    put("<h3>{}</h3>\n<dl class=\"list\">", say("realtime"));
    const auto entry = [&](const char* key, const std::string& value) {
      put("<dt>{}</dt><dd>{}</dd>", say(key), value);
    };
    const auto granted = [&](bool yes) { return say(yes ? "realtime.yes" : "realtime.no"); };
    entry("realtime.fifo", granted(loop.fifo));
    entry("realtime.pinned", granted(loop.pinned));
    entry("realtime.locked", granted(loop.memory_locked));
    if (loop.bearable_force > 0) {  // a hand with motors
      entry("motor_heat", say("motor_heat_value", number(100 * loop.worst_heat, 0)));
      std::vector<std::string> events;
      for (const auto& [event, name] : kSafetyEventNames) {
        if (loop.safety & bits(event)) events.push_back(say(fmt::format("safety.{}", name)));
      }
      entry("safety", events.empty() ? say("safety.none") : fmt::format("{}", fmt::join(events, "; ")));
    }
    put("</dl>\n");
  }

  void cpu_times() {
    if (course_.cpu_us.empty()) return;
    std::vector<float>& us = course_.cpu_us;
    std::sort(us.begin(), us.end());
    const auto quantile = [&](double q) {
      return static_cast<double>(us[static_cast<std::size_t>(q * static_cast<double>(us.size() - 1) + 0.5)]);
    };
    const double period = 1e6 / session_.header().servo_rate;
    // Twelve bins to a decade.
    const double lo = std::floor(std::log10(std::max(1e-2, static_cast<double>(us.front()))));
    const double hi = std::max(lo + 1, std::ceil(std::log10(std::max(1e-2, static_cast<double>(us.back())) * 1.0001)));
    std::vector<double> edges, counts;
    for (int i = 0; i <= static_cast<int>(12 * (hi - lo)); ++i) edges.push_back(std::pow(10.0, lo + i / 12.0));
    counts.resize(edges.size() - 1);
    for (const float v : us) {
      const auto above = std::upper_bound(edges.begin(), edges.end(), static_cast<double>(v));
      const auto bin = std::clamp<std::ptrdiff_t>(above - edges.begin() - 1, 0, static_cast<std::ptrdiff_t>(counts.size()) - 1);
      ++counts[static_cast<std::size_t>(bin)];
    }
    put("<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-labelledby=\"h-timing\"><table><caption>{}</caption><thead><tr>"
        "<th scope=\"col\">{}</th><th scope=\"col\">{}</th><th scope=\"col\">99 %</th><th scope=\"col\">{}</th><th scope=\"col\">{}</th>"
        "</tr></thead>\n<tbody><tr><td class=\"text\">{}</td><td>{} µs</td><td>{} µs</td><td>{} µs</td><td>{} µs</td></tr></tbody></table></div>\n",
        say("timing_caption", number(period, 0)), say("ticks"), say("median"), three_nines(), say("worst"), us.size(), number(quantile(0.5)), number(quantile(0.99)),
        number(quantile(0.999)), number(us.back()));
    put("<div class=\"scroll\">{}</div>\n",
        histogram(edges, counts, "µs",
                  say("histogram_alt", us.size(), number(quantile(0.5)), number(quantile(0.99)), number(us.back())),
                  number_text()));
  }

  /// The stream that a head-mounted display leaves, a row a frame; null without one.
  const StreamData* headset_frames() const {
    const auto& specs = session_.header().streams;
    for (std::size_t i = 0; i < specs.size() && i < session_.streams().size(); ++i)
      if (specs[i].name == "headset" && !session_.streams()[i].t.empty()) return &session_.streams()[i];
    return nullptr;
  }

  void headset() {
    const StreamData* frames = headset_frames();
    if (!frames) return;
    const auto& specs = session_.header().streams;
    const auto spec = std::find_if(specs.begin(), specs.end(), [](const StreamSpec& s) { return s.name == "headset"; });
    /// A column's known values, times `scale`, sorted.
    const auto column = [&](std::string_view name, double scale) {
      std::vector<double> values;
      for (std::size_t c = 0; c < spec->columns.size() && c < frames->columns.size(); ++c) {
        if (spec->columns[c].name != name) continue;
        for (const double v : frames->columns[c])
          if (std::isfinite(v)) values.push_back(v * scale);
      }
      std::sort(values.begin(), values.end());
      return values;
    };
    const auto sum = [](const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); };
    const std::size_t count = frames->t.size();
    const double drawn = sum(column("drawn", 1)), missed = sum(column("missed", 1));
    put("<section id=\"headset\" aria-labelledby=\"h-headset\">\n<h2 id=\"h-headset\">{}</h2>\n<p>{}</p>\n"
        "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-labelledby=\"h-headset\"><table><caption>{}</caption><thead><tr><th scope=\"col\"></th><th scope=\"col\">{}</th><th scope=\"col\">99 %</th>"
        "<th scope=\"col\">{}</th></tr></thead>\n<tbody>\n",
        say("headset"), say("headset_frames", count, number(drawn, 0), number(missed, 0)), say("headset_caption"),
        say("median"), say("worst"));
    const auto row = [&](const char* key, std::string_view name, double scale, const char* unit, bool least_is_worst = false) {
      std::vector<double> values = column(name, scale);
      if (values.empty()) return;
      if (least_is_worst) std::reverse(values.begin(), values.end());
      const auto at = [&](double q) {
        return quantity(values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)], unit);
      };
      put("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td></tr>\n", say(key), at(0.5), at(0.99), at(1));
    };
    row("pose_to_submit", "pose_to_submit_s", 1e3, "ms");
    row("frame_margin", "margin_s", 1e3, "ms", true);
    row("head_error", "position_error_m", 1e3, "mm");
    row("head_angle_error", "angle_error_rad", 1 / kDegree, "°");
    put("</tbody></table></div>\n</section>\n");
  }

  /// The stream that a picture on a screen leaves, a row a frame; null without one.
  const StreamData* picture_frames() const {
    const auto& specs = session_.header().streams;
    for (std::size_t i = 0; i < specs.size() && i < session_.streams().size(); ++i)
      if (specs[i].name == "picture" && !session_.streams()[i].t.empty()) return &session_.streams()[i];
    return nullptr;
  }

  void picture() {
    const StreamData* frames = picture_frames();
    if (!frames) return;
    const auto& specs = session_.header().streams;
    const auto spec = std::find_if(specs.begin(), specs.end(), [](const StreamSpec& s) { return s.name == "picture"; });
    const auto column = [&](std::string_view name) {
      std::vector<double> values;
      for (std::size_t c = 0; c < spec->columns.size() && c < frames->columns.size(); ++c)
        if (spec->columns[c].name == name)
          std::copy_if(frames->columns[c].begin(), frames->columns[c].end(), std::back_inserter(values),
                       [](double v) { return std::isfinite(v); });
      std::sort(values.begin(), values.end());
      return values;
    };
    const auto mean = [](const std::vector<double>& v) {
      return v.empty() ? 0.0 : std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
    };
    const std::vector<double> steps = column("quality_step");
    put("<section id=\"picture\" aria-labelledby=\"h-picture\">\n<h2 id=\"h-picture\">{}</h2>\n<p>{}</p>\n"
        "<table><caption>{}</caption><thead><tr><th scope=\"col\"></th><th scope=\"col\">{}</th><th scope=\"col\">99 %</th>"
        "<th scope=\"col\">{}</th></tr></thead>\n<tbody>\n",
        say("picture"),
        say("picture_frames", frames->t.size(), number(100 * mean(column("redrawn")), 0),
            steps.empty() ? 1 : static_cast<int>(steps.front()) + 1, steps.empty() ? 1 : static_cast<int>(steps.back()) + 1),
        say("picture_caption"), say("median"), say("worst"));
    const auto row = [&](const char* key, std::string_view name) {
      const std::vector<double> values = column(name);
      if (values.empty() || values.back() <= 0) return;
      const auto at = [&](double q) {
        return quantity(1e3 * values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)], "ms");
      };
      put("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td></tr>\n", say(key), at(0.5), at(0.99), at(1));
    };
    row("frame_period", "period_s");
    row("frame_record", "record_s");
    row("frame_gpu", "gpu_s");
    row("motion_to_photon", "motion_to_photon_s");
    put("</tbody></table>\n</section>\n");
  }

  void events() {
    const auto& all = session_.events();
    if (all.empty()) return;
    put("<section id=\"events\" class=\"long\" aria-labelledby=\"h-events\">\n<h2 id=\"h-events\">{}</h2>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-labelledby=\"h-events\"><table><thead><tr>"
        "<th scope=\"col\">{}</th><th scope=\"col\" class=\"text\">{}</th></tr></thead>\n<tbody>\n",
        say("events"), say("when"), say("what"));
    for (std::size_t i = 0; i < std::min(all.size(), kMostEvents); ++i) {
      put("<tr><th scope=\"row\">{}</th><td class=\"text\">{}: {}</td></tr>\n", number(to_seconds(all[i].t), 2),
          say(fmt::format("event.{}", name_of(all[i].kind))), escaped(all[i].text));
    }
    put("</tbody></table></div>\n");
    if (all.size() > kMostEvents) put("<p class=\"soft\">{}</p>\n", say("more_events", all.size() - kMostEvents));
    put("</section>\n");
  }

  void details() {
    const SessionHeader& h = session_.header();
    put("<section id=\"details\" class=\"long\" aria-labelledby=\"h-details\">\n<h2 id=\"h-details\">{}</h2>\n<dl class=\"list\">", say("details"));
    const auto entry = [&](const char* key, const std::string& value) {
      if (!value.empty()) put("<dt>{}</dt><dd>{}</dd>", say(key), value);
    };
    entry("scene", escaped(scene_name_));
    entry("hand", escaped(h.hand));
    std::vector<std::string> texts;
    for (const auto& tool : h.tools) texts.push_back(escaped(tool));
    entry("tools", fmt::format("{}", fmt::join(texts, ", ")));
    entry("servo_rate", fmt::format("{} Hz", number(h.servo_rate, 0)));
    if (h.voxel > 0) entry("voxel", fmt::format("{} mm", number(h.voxel * 1e3, 3)));
    entry("program", "Typodont " + escaped(h.program_version));
    entry("compiler", escaped(h.compiler));
    texts.clear();
    for (const auto& [name, seed] : h.seeds) texts.push_back(fmt::format("{} {}", escaped(name), seed));
    entry("seeds", fmt::format("{}", fmt::join(texts, ", ")));
    texts.clear();
    for (const auto& f : h.files) texts.push_back(fmt::format("{} <code>{}</code>", escaped(f.path), escaped(f.hash)));
    entry("files", fmt::format("{}", fmt::join(texts, "<br>")));
    entry("session_file", escaped(session_.file().filename().string()));
    put("</dl>\n</section>\n");
  }

  const SessionReader& session_;
  const ReportOptions& options_;
  Course course_;
  ScoreInput input_;
  Score score_;
  std::string scene_name_;
  std::optional<Task> task_;
  std::string out_;
};

}  // namespace

SessionPicture read_picture(const std::filesystem::path& png, std::string_view name, std::string_view title) {
  std::error_code code;
  if (std::filesystem::is_directory(png, code)) throw Error(png.string(), "", "a directory", "a PNG picture");
  std::ifstream in(png, std::ios::binary);
  if (!in) throw Error(png.string(), "", std::strerror(errno), "a readable PNG picture");
  SessionPicture picture{std::string(name), std::string(title), {}};
  picture.png.assign(std::istreambuf_iterator<char>(in), {});
  static constexpr std::uint8_t kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (picture.png.size() < 45 || std::memcmp(picture.png.data(), kSignature, 8) != 0) {
    throw Error(png.string(), "", "something else", "a PNG picture");
  }
  return picture;
}

ScoreInput score_input(const SessionReader& session) { return input_of(session, course_of(session)); }

Score score_session(const SessionReader& session) { return score_of(session, score_input(session)); }

std::string report_html(const SessionReader& session, const ReportOptions& options) {
  return Page(session, options).html();
}

SessionSummary summarize(const SessionReader& session, std::optional<Score> score) {
  return {session.file().filename().string(), session.header().date, session.header().trainee, scene_name_of(session),
          session.truncated(), score ? std::move(*score) : score_session(session)};
}

std::string learning_curve_html(std::span<const SessionSummary> sessions, Language language) {
  const Words words{language};
  std::string out = page_head(language, words.say("title.curve"));
  const auto put = [&]<class... Args>(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
  };
  std::vector<SessionSummary> all(sessions.begin(), sessions.end());
  std::stable_sort(all.begin(), all.end(), [](const SessionSummary& a, const SessionSummary& b) {
    return std::tie(a.date, a.file) < std::tie(b.date, b.file);
  });
  // Only sessions on the same scene can be compared.
  std::vector<std::string> scenes;
  for (const SessionSummary& s : all) {
    if (std::find(scenes.begin(), scenes.end(), s.scene) == scenes.end()) scenes.push_back(s.scene);
  }
  put("<header><h1>{}</h1><p class=\"where\">{}</p></header>\n<main>\n", words.say("title.curve"),
      words.say("sessions_count", all.size()));
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    std::vector<const SessionSummary*> mine;
    for (const SessionSummary& s : all) {
      if (s.scene == scenes[k]) mine.push_back(&s);
    }
    put("<section class=\"long\" aria-labelledby=\"scene-{0}\"><h2 id=\"scene-{0}\">{1}</h2>\n<div class=\"curves\">\n", k,
        scenes[k].empty() ? words.say("scene") : escaped(scenes[k]));
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
    curve(words.say("score"), "%", 100.0, [](const SessionSummary& s) -> std::optional<double> {
      if (s.score.full <= 0) return std::nullopt;
      return 100 * s.score.points / s.score.full;
    });
    for (const ScoreItem& item : mine.back()->score.items) {
      if (item.weight <= 0) continue;
      curve(words.name_of_item(item.name), item.unit, item.target, [&](const SessionSummary& s) -> std::optional<double> {
        for (const ScoreItem& other : s.score.items) {
          if (other.name == item.name) return other.value;
        }
        return std::nullopt;
      });
    }
    put("</div>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-labelledby=\"scene-{}\"><table><thead><tr><th "
        "scope=\"col\">{}</th><th scope=\"col\">{}</th><th scope=\"col\">{}</th>",
        k, words.say("session_file"), words.say("date"), words.say("score"));
    for (const ScoreItem& item : mine.back()->score.items) {
      if (item.weight > 0) put("<th scope=\"col\">{}</th>", words.name_of_item(item.name));
    }
    put("</tr></thead>\n<tbody>\n");
    for (const SessionSummary* s : mine) {
      put("<tr><th scope=\"row\">{}{}</th><td>{}</td><td>{}\u00a0%</td>", escaped(s->file),
          s->truncated ? " (" + words.say("cut_off") + ")" : std::string(), words.date(s->date),
          words.number(s->score.full > 0 ? 100 * s->score.points / s->score.full : 0, 0));
      for (const ScoreItem& item : mine.back()->score.items) {
        if (item.weight <= 0) continue;
        const auto& items = s->score.items;
        const auto it = std::find_if(items.begin(), items.end(), [&](const ScoreItem& i) { return i.name == item.name; });
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
